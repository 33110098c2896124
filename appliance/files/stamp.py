"""Whether a file has been replaced, told without reading it."""

from pathlib import Path


def file_stamp(path: Path | None) -> tuple[int, int, int] | None:
    """Number, size and time of change of a file; None where there is none."""
    try:
        found = None if path is None else path.stat()
    except OSError:
        return None
    return None if found is None else (found.st_ino, found.st_size, found.st_mtime_ns)
