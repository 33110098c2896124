"""Checks settings, scale, cameras, port, service, disk, cache and memory of an installation; changes nothing."""

import asyncio
import errno
import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal, NamedTuple

from appliance.cameras.liveness import Exposure
from appliance.cameras.source import CameraError
from appliance.service import systemd as service
from appliance.service.install import UNIT
from appliance.settings.file import SettingsError
from appliance.sizing.method import ScaleError
from appliance.supervisor.self_check import SelfCheck
from appliance.supervisor.settings import Settings, load, state_folder
from plc.listener import bind_error, listen
from plc.security.addresses import EVERY, EVERY_IPV4, served_in_words
from plc.security.secure_port import SecurePort

PICTURE_TIMEOUT_S = 10.0  # chosen
LEAST_FREE_SPACE_MB = 200  # chosen: of a disk; and memory that must remain beside the sizing station's


_ASKED = {EVERY_IPV4: "127.0.0.1", EVERY: "::1"}  # of an address that is bound


class Check(NamedTuple):
    """Outcome of one check.

    Attributes
    ----------
    name : str
    verdict : {"good", "note", "BAD"}
        `note`: the gauge works, with a restriction that the text names.
    text : str
        What was found, and what to do.
    """

    name: str
    verdict: Literal["good", "note", "BAD"]
    text: str

    def __str__(self) -> str:
        return f"{self.verdict:<5} {self.name:<9} {self.text}"


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
    checks: tuple[Callable[[Settings], Check], ...] = (
        _scale,
        _cameras,
        _port,
        _secure_port,
        _service,
        _disk,
        _history,
        _cache,
        _memory,
    )
    for check in checks:
        yield check(settings)


def _scale(settings: Settings) -> Check:
    """Rig file or empty line of the sizing method."""
    return Check(*settings.sizing.check_scale())


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


def _port(settings: Settings) -> Check:
    plc = settings.plc
    if not plc.plain:
        return Check("port", "good", "plain Modbus is off (plc.plain)")
    place = f"{plc.host}:{plc.port}"
    try:
        for bound in listen(plc.host, plc.port):
            bound.close()
    except OSError as error:
        if error.errno == errno.EADDRINUSE and asyncio.run(_answers(plc.host, plc.port)):
            return Check("port", "good", f"{place}: a gauge answers")
        if error.errno == errno.EACCES:
            return Check("port", "note", f"{place}: only root and the service may use it")
        return Check("port", "BAD", bind_error(error, plc.host, plc.port, "plc.port").sentence)
    served = served_in_words(plc.host)
    return Check("port", "note" if "only" in served else "good", f"{place}: free; it serves {served}")


async def _answers(host: str, port: int) -> bool:
    check = SelfCheck(lambda: socket.create_connection((_ASKED.get(host, host), port), timeout=2.0))
    try:
        return await check.heartbeat() is not None
    finally:
        check.close()


def _secure_port(settings: Settings) -> Check:
    files = settings.plc.tls.files
    if files is None:
        return Check("tls", "note", "none; see plc.tls and hotgauge certificates")
    secure = SecurePort(settings.plc.tls.port, files)
    asyncio.run(secure.load())
    if secure.trouble:
        return Check("tls", "BAD", secure.trouble)
    due = secure.due()
    return Check("tls", "BAD" if due else "good", due or "its certificate and the authority are in order")


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


def _disk(settings: Settings) -> Check:
    folder = state_folder(settings.plc)
    if folder is None:
        return Check("disk", "note", "nothing is kept over a restart; see plc.writes and plc.state_directory")
    return _writable("disk", folder, "set points are kept")


def _history(settings: Settings) -> Check:
    folder = settings.history.directory
    if folder is None:
        return Check("history", "note", "nothing that is measured is kept; see history.directory")
    return _writable("history", folder, "what is measured is kept")


def _cache(_: Settings) -> Check:
    given = os.environ.get("NUMBA_CACHE_DIR")
    if given is None:
        return _writable("cache", Path(__file__).parents[1], "compiled code is kept beside the program")
    return _writable("cache", Path(given), "compiled code is kept")


def _writable(name: str, folder: Path, what: str) -> Check:
    there = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    try:
        with tempfile.TemporaryFile(dir=there):
            free_mb = shutil.disk_usage(there).free >> 20
    except OSError as error:
        if error.errno == errno.EACCES and os.geteuid() != 0:  # it belongs to the service's user, as it should
            return Check(name, "note", f"{folder}: not writable for you; run the doctor with sudo to check it")
        return Check(name, "BAD", f"{folder}: {error.strerror}; make it writable for the user of the service")
    if free_mb < LEAST_FREE_SPACE_MB:
        return Check(name, "BAD", f"{folder}: {free_mb} MB free; make room for {LEAST_FREE_SPACE_MB} MB")
    return Check(name, "good", f"{folder}: {what}, {free_mb} MB free")


def _memory(settings: Settings) -> Check:
    there_mb = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") >> 20
    wanted_mb = settings.sizing.memory_max_mb + LEAST_FREE_SPACE_MB
    if there_mb < wanted_mb:
        return Check("memory", "BAD", f"{there_mb} MB; sizing.memory_max_mb needs {wanted_mb} MB with the rest")
    return Check("memory", "good", f"{there_mb} MB")
