"""A Mosquitto broker that can be away, and its own subscriber, which nobody here wrote."""

import json
import shutil
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path

from plc.security.certificates import Authority
from plc.security.roles import Role

MOSQUITTO = shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin:/usr/bin") or "mosquitto"
SUBSCRIBER = "reader"
PROBE = "hotgauge/probe"


class Broker:
    """A broker on 127.0.0.1 with TLS, for clients with a certificate, that keeps what its subscriber has not got."""

    def __init__(self, folder: Path, port: int) -> None:
        self.port = port
        self.folder = folder
        authority = Authority.make()
        authority.save(folder)
        authority.server(folder, ["127.0.0.1", "localhost"])
        for name in ("gauge", SUBSCRIBER):
            authority.client(folder, name, Role.VIEWER)
        (folder / "store").mkdir()
        lines = [
            f"listener {port} 127.0.0.1",
            f"cafile {folder / 'authority.pem'}",
            f"certfile {folder / 'server.pem'}",
            f"keyfile {folder / 'server.key'}",
            "require_certificate true",
            "allow_anonymous true",
            "persistence true",
            f"persistence_location {folder / 'store'}/",
            "max_queued_messages 0",
            "user root",
        ]
        (folder / "mosquitto.conf").write_text("\n".join(lines) + "\n")
        self._process: subprocess.Popen[bytes] | None = None
        self._subscriber: subprocess.Popen[str] | None = None
        self.received: list[tuple[str, str]] = []
        self._known = threading.Event()

    def start(self) -> None:
        self._process = subprocess.Popen(
            [MOSQUITTO, "-c", str(self.folder / "mosquitto.conf")], stderr=subprocess.DEVNULL
        )

    def stop(self) -> None:
        """End it as an administrator does; it keeps what its subscriber has not got."""
        if self._process is not None:
            self._process.terminate()
            self._process.wait(10)
            self._process = None

    def subscribe(self) -> None:
        """Have a subscriber whom the broker knows: from now on it gets everything, whenever either was away."""
        place = ["-h", "127.0.0.1", "-p", str(self.port), "--cafile", str(self.folder / "authority.pem")]
        place += ["--cert", str(self.folder / f"client-{SUBSCRIBER}.pem")]
        place += ["--key", str(self.folder / f"client-{SUBSCRIBER}.key"), "-q", "1"]
        probe = ["mosquitto_pub", *place, "-t", PROBE, "-m", "1", "-r"]
        assert self.wait_for(lambda: subprocess.run(probe, check=False, capture_output=True).returncode == 0, 10)
        words = ["mosquitto_sub", *place, "-c", "-i", SUBSCRIBER, "-t", "hotgauge/#", "-F", "%t %p"]
        self._subscriber = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        threading.Thread(target=self._read, args=(self._subscriber,), daemon=True).start()
        assert self.wait_for(self._known.is_set, 10)

    def _read(self, subscriber: subprocess.Popen[str]) -> None:
        for line in subscriber.stdout:
            topic, _, text = line.rstrip("\n").partition(" ")
            if topic == PROBE:
                self._known.set()
            else:
                self.received.append((topic, text))

    def rows(self, table: str) -> list[dict]:
        return [json.loads(text) for topic, text in list(self.received) if topic == f"hotgauge/{table}"]

    def wait_for(self, there: Callable[[], bool], seconds: float) -> bool:
        until_s = time.monotonic() + seconds
        while not there() and time.monotonic() < until_s:
            time.sleep(0.05)
        return there()

    def close(self) -> None:
        self.stop()
        if self._subscriber is not None:
            self._subscriber.kill()
            self._subscriber.wait(10)
            self._subscriber.stdout.close()
