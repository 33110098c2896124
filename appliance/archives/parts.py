"""What is already measured of an archive: one file for each recording, so that a measurement goes on where it ended."""

import hashlib
import json
import shutil
from collections.abc import Mapping
from pathlib import Path

from appliance.files.atomic_file import whole_file
from appliance.files.row_writer import Value

Rows = list[dict[str, Value]]


class Parts:
    """The folder of parts beside an output.

    Parameters
    ----------
    output : Path
        File that the parts become.
    options : mapping of str to str
        All that decides a value beside the recording itself: parts of other options do not count.

    Raises
    ------
    OSError
        The folder cannot be made.
    """

    def __init__(self, output: Path, options: Mapping[str, str]) -> None:
        self.folder = output.with_name(f"{output.name}.parts")
        self.folder.mkdir(parents=True, exist_ok=True)
        self._options = json.dumps(options, sort_keys=True)

    def read(self, place: Path) -> Rows | None:
        """Rows of a recording by its place; None if it was not measured yet, or has changed since."""
        try:
            rows: Rows = json.loads(place.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return rows

    def write(self, place: Path, rows: Rows) -> None:
        """Keep the rows of a recording at its place; raises `OSError`."""
        with whole_file(place) as file:
            json.dump(rows, file, allow_nan=False)

    def remove(self) -> None:
        """Delete all parts."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def place(self, recording: Path) -> Path:
        """Where the rows of a recording belong as its files are now; one that changes gets another place."""
        files = sorted(path for path in recording.rglob("*") if path.is_file())
        stats = [(str(path.relative_to(recording)), path.stat().st_size, path.stat().st_mtime_ns) for path in files]
        key = json.dumps([self._options, str(recording.resolve()), stats])
        return self.folder / f"{hashlib.sha256(key.encode()).hexdigest()[:32]}.json"
