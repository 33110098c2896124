"""Files that are replaced whole: a reader, a crash, a power cut or a full disk never meets half of one."""

import contextlib
import os
import tempfile
from collections.abc import Generator
from pathlib import Path
from typing import TextIO

READABLE_BY_ALL = 0o644


@contextlib.contextmanager
def whole_file(path: Path) -> Generator[TextIO]:
    """Open a text file that appears under its name only when all of it is on the disk; raises `OSError`."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
            os.fchmod(file.fileno(), READABLE_BY_ALL)
            yield file
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
