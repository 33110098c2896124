"""Board pictures taken through the page: `hotgauge capture` as a program of its own, and what it says as it judges.

The page loads no image library and opens no camera; where the running gauge holds the cameras, the command says so.
"""

import contextlib
import re
import signal
import subprocess
import threading
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from appliance.errors import HotgaugeError
from appliance.page.low_priority import low_priority_command

LINES_KEPT = 12  # chosen: what a person reads while holding a board
STOP_WITHIN_S = 10.0  # chosen: from the signal to stop until the program is ended
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")
SQUARES = re.compile(r"[1-9][0-9]?x[1-9][0-9]?")

What = Literal["boards", "low", "high"]
WHATS: tuple[What, ...] = ("boards", "low", "high")


class BoardPicturesError(HotgaugeError):
    """Board pictures cannot be taken; the message says why, and what to do."""


class BoardPictures:
    """Takes board pictures into folders, one program at a time.

    Parameters
    ----------
    folder : Path
        In it a folder for each set of board pictures.
    config : Path or None
        Settings file, which names the cameras.
    """

    def __init__(self, folder: Path, config: Path | None) -> None:
        self._folder = folder
        self._config = config
        self._program: subprocess.Popen[str] | None = None
        self._lines: deque[str] = deque(maxlen=LINES_KEPT)
        self._one_at_a_time = threading.Lock()
        self.name = ""

    @property
    def running(self) -> bool:
        """Whether pictures are being taken."""
        return self._program is not None and self._program.poll() is None

    @property
    def lines(self) -> list[str]:
        """What the program has said last, oldest first."""
        return list(self._lines)

    def begin(self, name: str, what: str, squares: str, length_mm: float) -> None:
        """Begin to take pictures.

        Parameters
        ----------
        name : str
            Of the folder, letters, digits, `-` and `_`; it is made, and what it holds stays.
        what : {"boards", "low", "high"}
            Poses of the board, or the board flat at one of both heights.
        squares : str
            Of the board, as `8x5`.
        length_mm : float
            Of boards the side of a square, else the height of the board's face above the rollers.

        Raises
        ------
        BoardPicturesError
            A name, squares or length that cannot be, pictures are being taken already, or the folder cannot be made.
        """
        if not NAME.fullmatch(name):
            raise BoardPicturesError(f"{name!r}: no name of a folder; give letters, digits, - and _, at most 40")
        if what not in WHATS or (what == "boards" and not SQUARES.fullmatch(squares)):
            raise BoardPicturesError(f"{squares!r}: no board; give its squares along both sides, as 8x5")
        words = _words(self._folder / name, what, squares, length_mm)
        if self._config is not None:
            words += ["--config", str(self._config)]
        with self._one_at_a_time:
            if self.running:
                raise BoardPicturesError(f"{self.name}: pictures are being taken; stop that first")
            try:
                self._folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise BoardPicturesError(f"{self._folder}: {error.strerror}; let the page's user write it") from error
            self._lines.clear()
            self.name = name
            self._program = _start(words)
            threading.Thread(target=self._read, args=(self._program,), daemon=True, name="board pictures").start()

    def stop(self) -> None:
        """End the program as Ctrl-C does, so that it says what is missing; what it stored stays."""
        with self._one_at_a_time:
            if self._program is None or not self.running:
                return
            self._program.send_signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._program.wait(STOP_WITHIN_S)
                return
            self._program.kill()
            self._program.wait()

    def _read(self, program: "subprocess.Popen[str]") -> None:
        with program:  # waits for it, and closes its output
            self._lines.extend(line.rstrip() for line in program.stdout or ())


def _words(place: Path, what: str, squares: str, length_mm: float) -> list[str]:
    if what == "boards":
        return ["boards", "--output", str(place), "--squares", squares, "--mm", f"{length_mm:g}"]
    return ["registration", "--output", str(place), "--height", what, f"--{what}-mm", f"{length_mm:g}"]


def _start(words: Sequence[str]) -> "subprocess.Popen[str]":
    command = low_priority_command(["capture", *words])
    return subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, bufsize=1
    )
