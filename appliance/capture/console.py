"""What `hotgauge capture` says while it runs: lines that stay, one line that is live on a terminal, and questions."""

import shutil
import time
from typing import TextIO

from appliance.capture.error import CaptureError

LIVE_PERIOD_S = 0.2
PIPED_PERIOD_S = 1.0  # between lines of what changes, where there is no terminal: the page shows them


class Console:
    """Writes to a stream.

    Parameters
    ----------
    output, answers : text stream
        Where lines go, and where the Enter key is read.
    """

    def __init__(self, output: TextIO, answers: TextIO) -> None:
        self._output = output
        self._answers = answers
        self._terminal = output.isatty()
        self._live: str = ""
        self._written_s = 0.0

    def say(self, line: str) -> None:
        """Write a line that stays."""
        self._clear()
        self._output.write(line + "\n")
        self._output.flush()

    def live(self, line: str) -> None:
        """Show what changes: in place on a terminal, else as a line now and then when it has changed."""
        now_s = time.monotonic()
        if now_s - self._written_s < (LIVE_PERIOD_S if self._terminal else PIPED_PERIOD_S) or line == self._live:
            return
        if self._terminal:
            width = shutil.get_terminal_size().columns - 1
            self._output.write("\r" + line[:width].ljust(min(width, len(self._live))))
        else:
            self._output.write(line + "\n")
        self._output.flush()
        self._live = line
        self._written_s = now_s

    def wait_for_enter(self, line: str) -> None:
        """Ask for the Enter key; raises `CaptureError` where nobody can press it."""
        self.say(f"{line}, then press Enter")
        if not self._answers.readline():
            raise CaptureError("nobody answers on standard input; run the command on a terminal")

    def _clear(self) -> None:
        if self._terminal and self._live:
            self._output.write("\r" + " " * min(len(self._live), shutil.get_terminal_size().columns - 1) + "\r")
        self._live = ""
