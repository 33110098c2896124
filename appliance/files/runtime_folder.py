"""The runtime directory: what a running gauge leaves there is gone after it, and read by the page alone."""

import os
import tempfile
from pathlib import Path

RUNTIME_VARIABLE = "RUNTIME_DIRECTORY"  # of systemd


def runtime_folder() -> Path | None:
    """The runtime directory that this process was given; None for none."""
    given = os.environ.get(RUNTIME_VARIABLE, "").partition(":")[0]
    return Path(given) if given else None


def give_runtime_folder(port: int) -> None:
    """Give this process and its children a runtime directory, as a service manager would; none if that cannot be.

    Parameters
    ----------
    port : int
        Of the gauge: two gauges on one computer have two directories.
    """
    if runtime_folder() is not None:
        return
    above = Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir())
    folder = above / f"hotgauge-{os.getuid()}-{port}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        if folder.lstat().st_uid != os.getuid() or folder.is_symlink():
            return
    except OSError:
        return
    os.environ[RUNTIME_VARIABLE] = str(folder)


def preview_file(folder: Path, station: str) -> Path:
    """File of a station's preview.

    Parameters
    ----------
    folder : Path
    station : {"sizing", "ingot"}
    """
    return folder / f"{station}-preview.json"
