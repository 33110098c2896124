"""Runs a command in this process and says what is wrong with how it ended."""

import contextlib
import hashlib
import io
import os
import re
import signal
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType, TracebackType
from typing import NamedTuple, Self

from appliance.cli import main as cli

LONGEST_S = 20.0  # of a processor's time: a busy computer hangs nothing
LONGEST_WAIT_S = 200.0  # for what waits and computes nothing
MOST_KB = 2_000_000  # beyond what this process had, which has run other tests
SENTENCE = re.compile(r"hotgauge: [^\n]+\n")


class TooLongError(BaseException):
    """No `except Exception` stops it."""


class Ending(NamedTuple):
    """How a command ended: its exit code, what it said on standard error, and what is wrong with that, if anything."""

    code: int
    said: str
    problem: str


def tried(words: list[str], folder: Path) -> Ending:
    """Run a command in a folder."""
    before = _contents(folder)
    with contextlib.chdir(folder):
        code, said, problem = _run(lambda: cli.main(words))
    after = _contents(folder)
    if not problem and any(after.get(file) != content for file, content in before.items()):
        problem = "an input was changed"
    new = {file for file in after.keys() - before.keys() if not file.startswith("plots/")}
    new = {file for file in new if not file.endswith(("-shm", "-wal"))}  # SQLite's own, beside a history that is read
    if not problem and ((code == 2 and new) or any(Path(file).name.startswith(".") for file in new)):
        problem = f"left behind: {min(new)}"
    return Ending(code, said, problem)


class _Trouble:
    """Keeps what a command raises: its exit code, or what people would see as a traceback."""

    def __init__(self) -> None:
        self.code, self.text = -1, ""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, _: object, error: BaseException | None, trace: TracebackType | None) -> bool:
        if isinstance(error, SystemExit):
            self.code = error.code if isinstance(error.code, int) else 99
        elif isinstance(error, TooLongError):
            self.text = f"still working after {LONGEST_S:.0f} s"
        elif error is not None:
            last = traceback.extract_tb(trace)[-1]
            self.text = f"traceback: {type(error).__name__}: {error} ({Path(last.filename).name}:{last.lineno})"
        return not isinstance(error, KeyboardInterrupt)


def _run(command: Callable[[], int]) -> tuple[int, str, str]:
    Path("/proc/self/clear_refs").write_text("5")  # the peak of memory counts from now (proc(5))
    had_kb = _peak_kb()
    with _captured() as captured, _limited(), warnings.catch_warnings(), _Trouble() as trouble:
        warnings.simplefilter("error")
        trouble.code = command()
    said = captured[0]
    if _peak_kb() - had_kb > MOST_KB:
        return trouble.code, said, "more than 2 GB of memory"
    return trouble.code, said, trouble.text or _fault(trouble.code, said)


def _peak_kb() -> int:
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def _fault(code: int, said: str) -> str:
    if code not in {0, 1, 2}:
        return f"exit {code}"
    if said and not (code == 2 and SENTENCE.fullmatch(said)):
        return f"no single sentence: {said[:200]!r}"
    return "exit 2 without a word" if code == 2 and not said else ""


@contextlib.contextmanager
def _captured() -> Iterator[list[str]]:
    """Standard output thrown away and standard error kept, of libraries in C too."""
    kept: list[str] = []
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        saved = os.dup(1), os.dup(2)
        os.dup2(out.fileno(), 1)
        os.dup2(err.fileno(), 2)
        streams = [io.TextIOWrapper(os.fdopen(os.dup(number), "wb"), encoding="utf-8") for number in (1, 2)]
        python = sys.stdout, sys.stderr
        sys.stdout, sys.stderr = streams
        try:
            yield kept
        finally:
            sys.stdout, sys.stderr = python
            for stream in streams:
                stream.close()
            for number, one in zip((1, 2), saved, strict=True):
                os.dup2(one, number)
                os.close(one)
            err.seek(0)
            kept.append(err.read().decode("utf-8", errors="replace"))


@contextlib.contextmanager
def _limited() -> Iterator[None]:
    def stop(_: int, __: FrameType | None) -> None:
        raise TooLongError

    limits = {
        signal.SIGPROF: (signal.ITIMER_PROF, LONGEST_S),
        signal.SIGALRM: (signal.ITIMER_REAL, LONGEST_WAIT_S),
    }
    before = {number: signal.signal(number, stop) for number in limits}
    for timer, seconds in limits.values():
        signal.setitimer(timer, seconds)
    try:
        yield
    finally:
        for number, (timer, _) in limits.items():
            signal.setitimer(timer, 0)
            signal.signal(number, before[number])


def _contents(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
