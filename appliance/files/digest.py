"""SHA-256 of files, by which a calibration is known again."""

from hashlib import sha256
from pathlib import Path


def file_sha256(file: Path | None) -> str:
    """SHA-256 of a file's content, hexadecimal; empty without a file, or if it cannot be read."""
    try:
        return "" if file is None else sha256(file.read_bytes()).hexdigest()
    except OSError:
        return ""
