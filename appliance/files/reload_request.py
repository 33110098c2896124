"""How the page asks the gauge to read its settings and its calibration again: a file in a folder that both write."""

import os
import time
from pathlib import Path

from appliance.files.runtime_folder import runtime_folder

REQUEST_FILE = "reload"
HEARD_WITHIN_S = 5.0  # chosen: a gauge looks every second
LOOK_PERIOD_S = 0.05
STATE_VARIABLE = "STATE_DIRECTORY"  # of systemd


def _request_file() -> Path | None:
    """As a service in the state directory, for the page may not write into the gauge's runtime directory."""
    given = os.environ.get(STATE_VARIABLE, "").partition(":")[0]
    folder = Path(given) if given else runtime_folder()
    return None if folder is None else folder / REQUEST_FILE


def ask_for_reload() -> str:
    """Ask the gauge to read its settings and its calibration again, and wait until it has heard that.

    Returns
    -------
    str
        Why it has not; empty if it has.
    """
    file = _request_file()
    if file is None:
        return "no folder is shared with the gauge"
    try:
        file.touch()
    except OSError as error:
        return f"{file}: {error.strerror}"
    until_s = time.monotonic() + HEARD_WITHIN_S
    while file.exists():
        if time.monotonic() > until_s:
            file.unlink(missing_ok=True)
            return f"it has not heard the request within {HEARD_WITHIN_S:g} s, so it does not run here"
        time.sleep(LOOK_PERIOD_S)
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
