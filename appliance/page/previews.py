"""The pictures that the measuring processes leave in the runtime directory, about once a second."""

import base64
import json
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from appliance.files.runtime_folder import preview_file

OLD_AFTER_S = 5.0  # chosen: five times the period at which they are written


class Preview(NamedTuple):
    """Pictures of one exposure of a station.

    Attributes
    ----------
    version : int
        Changes with each exposure.
    pictures : tuple of bytes
        JPEG.
    figures : dict
        What was measured in them.
    rate_hz : float or None
        Exposures of the camera since the preview before; None for the first.
    """

    version: int
    pictures: tuple[bytes, ...]
    figures: dict[str, Any]
    rate_hz: float | None = None


class Previews:
    """Previews of all stations, read anew when they have changed.

    Parameters
    ----------
    folder : Path or None
        Runtime directory; None for none.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._read: dict[str, Preview] = {}
        self._one_at_a_time = threading.Lock()

    def newest(self, station: str) -> Preview | None:
        """Preview of a station; None if there is none, or only an old one.

        Parameters
        ----------
        station : {"sizing", "ingot"}
        """
        if self._folder is None:
            return None
        file = preview_file(self._folder, station)
        try:
            written = file.stat()
            if time.time() - written.st_mtime > OLD_AFTER_S:
                return None
            with self._one_at_a_time:
                known = self._read.get(station)
                if known is None or known.version != written.st_mtime_ns:
                    self._read[station] = known = _read(file, written.st_mtime_ns, known)
        except (OSError, ValueError, KeyError, TypeError):
            return None
        return known

    def address(self, station: str, number: int) -> str:
        """Address of a picture in the page; empty if there is none.

        Parameters
        ----------
        station : {"sizing", "ingot"}
        number : int
            0 for the left or only one.
        """
        preview = self.newest(station)
        if preview is None or number >= len(preview.pictures):
            return ""
        return f"/pictures/{station}/{number}?version={preview.version}"


def _read(file: Path, version: int, before: Preview | None) -> Preview:
    document = json.loads(file.read_text(encoding="utf-8"))
    figures = document["figures"]
    pictures = tuple(base64.b64decode(one) for one in document["pictures"])
    return Preview(version, pictures, figures, _rate_hz(figures, None if before is None else before.figures))


def _rate_hz(figures: Mapping[str, Any], before: Mapping[str, Any] | None) -> float | None:
    if before is None:
        return None
    exposures = figures["sequence"] - before["sequence"]
    elapsed_ms = figures["exposed_utc_ms"] - before["exposed_utc_ms"]
    return 1000 * exposures / elapsed_ms if exposures > 0 and elapsed_ms > 0 else None
