"""Measures recordings of an archive without looking at them, and ends as it is told; loads nothing that is slow."""

import os
import signal
from pathlib import Path

FRAMES = 2


def counted(recording: Path, log: Path) -> list[dict]:
    """Rows of a recording without measuring it, and a line for each call."""
    with log.open("a") as file:
        file.write(f"{recording.name}\n")
    return [{"frame": number, "diameter_mm": 100.0 + number, "reasons": ["no_bar"]} for number in range(FRAMES)]


def ends_once(recording: Path, log: Path) -> list[dict]:
    """As `counted`, but the process is killed on the second recording the first time."""
    mark = log.with_suffix(".killed")
    if recording.name == "second" and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return counted(recording, log)


def ends_always(recording: Path, log: Path) -> list[dict]:
    if recording.name == "second":
        os.kill(os.getpid(), signal.SIGKILL)
    return counted(recording, log)


def refuses(recording: Path, log: Path) -> list[dict]:
    if recording.name == "second":
        return [{"frame": None, "error": "right/000001.png: the file breaks off"}]
    return counted(recording, log)
