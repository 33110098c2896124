"""Checks settings, scales, cameras, addresses, disk, clock and versions of an installation; changes nothing."""

import subprocess
from collections.abc import Iterator
from pathlib import Path

from appliance.cameras.liveness import Exposure
from appliance.cameras.source import CameraError
from appliance.ingot.reader_setup import ReferencesError, load_view, make_reader
from appliance.service import systemd as service
from appliance.service.checks import FOR_GOOD_WORK, FOR_THE_START, Check
from appliance.service.install import UNIT
from appliance.settings.file import SettingsError
from appliance.sizing.method import ScaleError
from appliance.supervisor.ingot_client import is_on
from appliance.supervisor.settings import Settings, load

PICTURE_TIMEOUT_S = 10.0  # chosen


def examine(config: Path | None) -> Iterator[Check]:
    """Yield each check when it is done; if the settings cannot be used, theirs is the only one.

    Parameters
    ----------
    config : Path or None
        Settings file; None for the defaults.
    """
    try:
        settings = load(config)
    except SettingsError as error:
        yield Check("settings", "BAD", str(error))
        return
    yield Check("settings", "good", f"{config or 'the defaults'}")
    for check in (*FOR_THE_START, *FOR_GOOD_WORK, _cameras, _ingot_camera, _service):
        yield check(settings)


def _cameras(settings: Settings) -> Check:
    sizing = settings.sizing
    kind = sizing.camera.kind
    try:
        with sizing.make_source() as source:
            exposed = source.next(PICTURE_TIMEOUT_S)
        if exposed is None:
            return Check("cameras", "BAD", f"{kind}: no pictures within {PICTURE_TIMEOUT_S:.0f} s; check the cameras")
        pictures = Exposure.from_source(exposed).pictures
        sizing.check_pictures(pictures)
    except CameraError as error:
        return Check("cameras", "BAD", f"{kind}: {error}")
    except ScaleError as error:
        return Check("cameras", "BAD", f"{kind}: pictures do not fit: {error}")
    rows, columns = pictures[0].shape[:2]
    what = "a pair" if len(pictures) > 1 else "a picture"
    return Check("cameras", "good", f"{kind}: {what} of {columns} x {rows} pixels")


def _ingot_camera(settings: Settings) -> Check:
    ingot = settings.ingot
    if not is_on(ingot):
        return Check("ingots", "note", "no ingot station; see ingot.camera")
    kind = ingot.camera.kind
    try:
        with ingot.camera.make_source() as source:
            frame = source.next(PICTURE_TIMEOUT_S)
        if frame is None:
            return Check("ingots", "BAD", f"{kind}: no picture within {PICTURE_TIMEOUT_S:.0f} s; check the camera")
        if ingot.references is not None:
            make_reader(ingot, load_view(ingot.references), frame.picture)
    except CameraError as error:
        return Check("ingots", "BAD", f"{kind}: {error}")
    except ReferencesError as error:
        return Check("ingots", "BAD", f"{kind}: pictures do not fit: {error}")
    rows, columns = frame.picture.shape[:2]
    return Check("ingots", "good", f"{kind}: a picture of {columns} x {rows} pixels")


def _service(_: Settings) -> Check:
    if not Path("/run/systemd/system").is_dir():
        return Check("service", "note", "this computer does not run systemd; start `hotgauge run` by other means")
    if not service.available():
        return Check("service", "BAD", "systemd-python is missing; pip install systemd-python")
    if not (Path("/") / UNIT).is_file():
        return Check("service", "note", "not installed; as root: hotgauge install")
    asked = subprocess.run(["systemctl", "is-active", UNIT.name], check=False, capture_output=True, text=True)
    state = asked.stdout.strip() or "unknown"
    if state == "active":
        return Check("service", "good", "active")
    return Check("service", "BAD", f"{state}; see: journalctl -u hotgauge")
