"""Runs a command in this process and says what is wrong with how it ended."""

import contextlib
import gc
import hashlib
import io
import os
import re
import resource
import signal
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import NamedTuple

from appliance.cli import main as cli

LONGEST_S = 20.0
MOST_KB = 2_000_000
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
    if not problem and ((code == 2 and new) or any(Path(file).name.startswith(".") for file in new)):
        problem = f"left behind: {min(new)}"
    return Ending(code, said, problem)


def _run(command: Callable[[], int]) -> tuple[int, str, str]:
    code, trouble = -1, ""
    with _captured() as captured, _limited(), warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            code = command()
        except SystemExit as left:
            code = left.code if isinstance(left.code, int) else 99
        except TooLongError:
            trouble = f"still working after {LONGEST_S:.0f} s"
        except Exception as error:  # whatever it is: people would see a traceback
            last = traceback.extract_tb(error.__traceback__)[-1]
            trouble = f"traceback: {type(error).__name__}: {error} ({Path(last.filename).name}:{last.lineno})"
        gc.collect()
    said = captured[0]
    if not trouble and resource.getrusage(resource.RUSAGE_SELF).ru_maxrss > MOST_KB:
        trouble = "more than 2 GB of memory"
    if not trouble and code not in {0, 1, 2}:
        trouble = f"exit {code}"
    if not trouble and said and not (code == 2 and SENTENCE.fullmatch(said)):
        trouble = f"no single sentence: {said[:200]!r}"
    if not trouble and code == 2 and not said:
        trouble = "exit 2 without a word"
    return code, said, trouble


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

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, LONGEST_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _contents(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
