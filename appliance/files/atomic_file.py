"""Replaces files whole: after a crash, a power cut or on a full disk the old file or the new one is there."""

import contextlib
import errno
import os
import tempfile
from collections.abc import Generator
from pathlib import Path
from typing import TextIO

FILE_MODE = 0o644  # all users may read it; `mkstemp` alone would give 0o600


@contextlib.contextmanager
def whole_place(path: Path, mode: int = FILE_MODE) -> Generator[Path]:
    """A place to write a file at, which gets its name only when all of it is on the disk.

    Behind a link its target is replaced. A folder, a device or a pipe is never replaced.

    Parameters
    ----------
    path : Path
    mode : int
        Who may read and write it.

    Raises
    ------
    OSError
        It cannot be written; the error names `path`, not the place that nobody has asked for.
    """
    target = path.resolve()
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if target.exists() and not target.is_file():
        raise OSError(errno.EINVAL, "Is a device or a pipe and no file", str(path))
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
    temporary = Path(name)
    try:
        os.fchmod(handle, mode)
        yield temporary
        os.fsync(handle)
        temporary.replace(target)
    finally:
        os.close(handle)
        temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def whole_file(path: Path, mode: int = FILE_MODE) -> Generator[TextIO]:
    """Open a text file that appears under its name only when all of it is on the disk; raises `OSError`.

    Parameters
    ----------
    path : Path
    mode : int
        Who may read and write it.
    """
    with whole_place(path, mode) as place, place.open("w", encoding="utf-8", newline="") as file:
        yield file


def file_state(file: Path | None) -> tuple[int, int, int]:
    """Numbers that change when a file does; zeros for one that cannot be seen."""
    try:
        found = None if file is None else file.stat()
    except OSError:
        found = None
    return (0, 0, 0) if found is None else (found.st_ino, found.st_mtime_ns, found.st_size)
