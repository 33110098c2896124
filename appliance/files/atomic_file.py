"""Replaces files whole: after a crash, a power cut or on a full disk the old file or the new one is there."""

import contextlib
import os
import tempfile
from collections.abc import Generator
from pathlib import Path
from typing import TextIO

FILE_MODE = 0o644  # all users may read it; `mkstemp` alone would give 0o600


@contextlib.contextmanager
def whole_file(path: Path) -> Generator[TextIO]:
    """Open a text file that takes its name only when all of it is on the disk; raises `OSError`."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
            os.fchmod(file.fileno(), FILE_MODE)
            yield file
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
