"""Files that are replaced whole: a reader, a crash or a full disk never meets half of one."""

import contextlib
import os
from collections.abc import Generator
from pathlib import Path
from typing import TextIO


@contextlib.contextmanager
def whole_file(path: Path) -> Generator[TextIO]:
    """A text file to write that appears under its name only when all of it is written; raises `OSError`."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with temporary.open("x", encoding="utf-8", newline="") as file:
            yield file
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
