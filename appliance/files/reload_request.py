"""How the page asks the gauge to read its settings and its calibration again: a file in a folder that both write."""

import os
from pathlib import Path

from appliance.files.runtime_folder import runtime_folder

REQUEST_FILE = "reload"
STATE_VARIABLE = "STATE_DIRECTORY"  # of systemd


def _request_file() -> Path | None:
    """As a service in the state directory, for the page may not write into the gauge's runtime directory."""
    given = os.environ.get(STATE_VARIABLE, "").partition(":")[0]
    folder = Path(given) if given else runtime_folder()
    return None if folder is None else folder / REQUEST_FILE


def ask_for_reload() -> str:
    """Ask the gauge to read its settings and its calibration again; why that cannot be, empty if it could."""
    file = _request_file()
    if file is None:
        return "no folder is shared with the gauge"
    try:
        file.touch()
    except OSError as error:
        return f"{file}: {error.strerror}"
    return ""


def was_asked_for_reload() -> bool:
    """Whether somebody has asked since the last call."""
    file = _request_file()
    if file is None:
        return False
    try:
        file.unlink()
    except OSError:
        return False
    return True
