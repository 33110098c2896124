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
        words = ["mosquitto_sub", "-h", "127.0.0.1", "-p", str(self.port), "-q", "1", "-c", "-i", SUBSCRIBER]
        words += ["-t", "hotgauge/#", "-F", "%t %p", "--cafile", str(self.folder / "authority.pem")]
        words += ["--cert", str(self.folder / f"client-{SUBSCRIBER}.pem")]
        words += ["--key", str(self.folder / f"client-{SUBSCRIBER}.key")]
        self._subscriber = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        threading.Thread(target=self._read, args=(self._subscriber,), daemon=True).start()

    def _read(self, subscriber: subprocess.Popen[str]) -> None:
        for line in subscriber.stdout:
            topic, _, text = line.rstrip("\n").partition(" ")
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
