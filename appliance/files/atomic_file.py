"""Replaces files whole: after a crash, a power cut or on a full disk the old file or the new one is there."""

import contextlib
import os
import tempfile
from collections.abc import Generator
from pathlib import Path
from typing import TextIO

FILE_MODE = 0o644  # all users may read it; `mkstemp` alone would give 0o600


@contextlib.contextmanager
def whole_place(path: Path) -> Generator[Path]:
    """A place to write a file at, which gets its name only when all of it is on the disk.

    Raises
    ------
    OSError
        It cannot be written; the error names `path`, not the place that nobody has asked for.
    """
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
    temporary = Path(name)
    try:
        os.fchmod(handle, FILE_MODE)
        yield temporary
        os.fsync(handle)
        temporary.replace(path)
    finally:
        os.close(handle)
        temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def whole_file(path: Path) -> Generator[TextIO]:
    """Open a text file that appears under its name only when all of it is on the disk; raises `OSError`."""
    with whole_place(path) as place, place.open("w", encoding="utf-8", newline="") as file:
        yield file
