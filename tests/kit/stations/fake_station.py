"""A measuring process without cameras: does what the file named by FAKE_STATION says, twenty times a second."""

import hashlib
import json
import os
import select
import signal
import socket
import sys
import time
from pathlib import Path

from messages import reading

from appliance.processes.link import StationLink
from appliance.processes.message import StateMessage


def main() -> None:
    connection = socket.socket(fileno=int(sys.argv[1]))
    settings = json.loads(connection.makefile("rb").readline())
    rig = Path(settings["rig"]).read_bytes() if settings.get("rig") else b""  # once, as a station reads it
    scale_sha256 = hashlib.sha256(rig).hexdigest() if rig else ""
    link = StationLink(connection)
    sequence = 0
    while True:
        sequence += 1
        act(Path(os.environ["FAKE_STATION"]).read_text(encoding="utf-8"), link, connection, sequence, scale_sha256)
        if select.select([connection], [], [], 0.05)[0] and not connection.recv(1):
            return


def act(mode: str, link: StationLink, connection: socket.socket, sequence: int, scale_sha256: str) -> None:
    if mode == "measure":
        link.send(
            reading(
                sequence=sequence,
                exposed_monotonic_s=time.monotonic() - 0.02,
                exposed_utc_ms=round(1000 * time.time()),
                diameter_mm=200 + sequence % 50,
                scale_sha256=scale_sha256,
            )
        )
    elif mode == "break off":
        connection.send(reading(diameter_mm=999.0).model_dump_json().encode()[:-10])
        os.kill(os.getpid(), signal.SIGKILL)
    elif mode == "babble":
        connection.send(b'{"kind": "reading", "elapsed_ms": NaN}\n')
    elif mode.startswith("expose "):
        link.send(reading(sequence=sequence, exposed_monotonic_s=float(mode.removeprefix("expose "))))
    elif mode == "start":
        link.send(StateMessage(state="starting"))
    elif mode.startswith("fault "):
        link.send(StateMessage(state="faulty", fault=mode.removeprefix("fault "), detail="left.png: broken; mend it"))
    elif mode == "end":
        sys.exit(3)
    elif mode != "be silent":
        raise ValueError(mode)


if __name__ == "__main__":
    main()
