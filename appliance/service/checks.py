"""Checks of an installation that hold no camera: what `run` needs to start, each with what to do about it."""

import asyncio
import errno
import importlib.metadata
import importlib.util
import os
import re
import shutil
import socket
import sqlite3
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Literal, NamedTuple

from appliance.cameras.source import CameraError
from appliance.files.digest import file_sha256
from appliance.history import database
from appliance.history.schema import HistoryError, check_readable
from appliance.ingot.reader_setup import ReferencesError, load_view
from appliance.supervisor.ingot_client import is_on
from appliance.supervisor.self_check import SelfCheck
from appliance.supervisor.settings import Settings, state_folder
from plc.listener import bind_error, listen
from plc.security.addresses import EVERY, EVERY_IPV4, served_in_words
from plc.security.secure_port import SecurePort

LEAST_FREE_SPACE_MB = 200  # chosen: of a disk; and memory that must remain beside the stations'
EARLIEST_YEAR = 2026  # of this software: a clock before it was never set

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
        return f"{self.verdict:<5} {self.name:<10} {self.text}"


def scale(settings: Settings) -> Check:
    """Rig file or empty line of the sizing method, and whether a known error that is taken off belongs to it."""
    found = Check(*settings.sizing.check_scale())
    why = settings.sizing.adjustment.refusal(file_sha256(settings.sizing.scale_file))
    return Check(found.name, "BAD", why) if why and found.verdict != "BAD" else found


def references(settings: Settings) -> Check:
    """References of the ingot station."""
    if not is_on(settings.ingot):
        return Check("references", "note", "no ingot station; see ingot.camera")
    folder = settings.ingot.references
    if folder is None:
        if settings.ingot.camera.own_ingot_view() is None:
            text = "ingot.references is not set; give the folder with top.png and bottom.png"
            return Check("references", "BAD", text)
        return Check("references", "note", f"none; {settings.ingot.camera.in_words} has its own")
    try:
        load_view(folder)
    except ReferencesError as error:
        return Check("references", "BAD", str(error))
    return Check("references", "good", str(folder))


def recordings(settings: Settings) -> Check:
    """Recordings that stand in for cameras."""
    stations = {"sizing": settings.sizing.camera, "ingot": settings.ingot.camera}
    played = [name for name, camera in stations.items() if camera.kind == "recording"]
    for station in played:
        source = settings.sizing.make_source() if station == "sizing" else settings.ingot.camera.make_source()
        try:
            with source:
                pass
        except CameraError as error:
            return Check("recordings", "BAD", f"{station}.camera: {error}")
    return Check("recordings", "good", ", ".join(played) or "none is played")


def port(settings: Settings) -> Check:
    """Address and port of plain Modbus."""
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


async def _answers(host: str, number: int) -> bool:
    check = SelfCheck(lambda: socket.create_connection((_ASKED.get(host, host), number), timeout=2.0))
    try:
        return await check.heartbeat() is not None
    finally:
        check.close()


def secure_port(settings: Settings) -> Check:
    """Certificates of the secure port."""
    files = settings.plc.tls.files
    if files is None:
        return Check("tls", "note", "none; see plc.tls and hotgauge certificates")
    secure = SecurePort(settings.plc.tls.port, files)
    asyncio.run(secure.load())
    if secure.trouble:
        return Check("tls", "BAD", secure.trouble)
    due = secure.due()
    return Check("tls", "note" if due else "good", due or "its certificate and the authority are in order")


def delivery(settings: Settings) -> Check:
    """What leaves the gauge beside the PLC: libraries, files and the port of metrics."""
    wanted = {"mqtt": ("paho", bool(settings.mqtt.host)), "metrics": ("prometheus_client", settings.metrics.port > 0)}
    for extra, (library, needed) in wanted.items():
        if needed and importlib.util.find_spec(library) is None:
            return Check("delivery", "BAD", f"{extra}: a library is missing; pip install 'hotgauge[{extra}]'")
    mqtt = settings.mqtt
    for name in ("authority", "certificate", "key", "credentials"):
        file: Path | None = getattr(mqtt, name)
        if mqtt.host and file is not None and not os.access(file, os.R_OK):
            return Check("delivery", "BAD", f"{file}: cannot be read; see mqtt.{name}")
    if settings.metrics.port:
        place = f"{settings.metrics.host}:{settings.metrics.port}"
        try:
            for bound in listen(settings.metrics.host, settings.metrics.port):
                bound.close()
        except OSError as error:
            if error.errno != errno.EADDRINUSE or not asyncio.run(_answers(settings.plc.host, settings.plc.port)):
                return Check("delivery", "BAD", f"metrics: {place}: {error.strerror}; set metrics.port")
    named = [f"MQTT to {mqtt.host}"] * bool(mqtt.host) + ["metrics"] * bool(settings.metrics.port)
    return Check("delivery", "good", " and ".join(named) or "to the PLC only")


def disk(settings: Settings) -> Check:
    """Folder of set points."""
    folder = state_folder(settings.plc)
    if folder is None:
        return Check("disk", "note", "nothing is kept over a restart; see plc.writes and plc.state_directory")
    return _writable("disk", folder, "set points are kept")


def history(settings: Settings) -> Check:
    """Folder and file of the history."""
    folder = settings.history.directory
    if folder is None:
        return Check("history", "note", "nothing that is measured is kept; see history.directory")
    if trouble := _history_trouble(folder / database.FILE_NAME):
        return Check("history", "BAD", trouble)
    return _writable("history", folder, "what is measured is kept")


def _history_trouble(file: Path) -> str:
    if not file.is_file():
        return ""
    try:
        connection = sqlite3.connect(f"{file.absolute().as_uri()}?mode=ro", uri=True)
        try:
            if connection.execute("PRAGMA user_version").fetchone()[0]:
                check_readable(connection, str(file))
        finally:
            connection.close()
    except HistoryError as error:
        return str(error) if "newer" in str(error) else ""
    except sqlite3.Error as error:
        return f"{file}: {error}; it is set aside at the start, and what it holds is then no longer read"
    return ""


def black_boxes(settings: Settings) -> Check:
    """Folders and memory of both black boxes."""
    boxes = {"sizing": settings.sizing, "ingot": settings.ingot}
    used = {name: station for name, station in boxes.items() if station.black_box.directory is not None}
    for name, station in used.items():
        box = station.black_box
        if 2 * box.memory_max_mb > station.memory_max_mb:
            text = f"{name}.black_box.memory_max_mb is more than half of {name}.memory_max_mb; lower it"
            return Check("blackbox", "BAD", text)
        found = _writable("blackbox", Path(box.directory or "."), "pictures of alarms are kept")
        if found.verdict == "BAD":
            return found
    if not used:
        return Check("blackbox", "note", "no pictures of alarms are kept; see sizing.black_box.directory")
    return Check("blackbox", "good", ", ".join(used))


def cache(_: Settings) -> Check:
    """Folder of compiled code."""
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


def memory(settings: Settings) -> Check:
    """Memory of the computer against what the stations may use."""
    there_mb = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") >> 20
    wanted_mb = settings.sizing.memory_max_mb + LEAST_FREE_SPACE_MB
    if is_on(settings.ingot):
        wanted_mb += settings.ingot.memory_max_mb
    if there_mb < wanted_mb:
        text = f"{there_mb} MB; the stations may use {wanted_mb} MB with the rest, see sizing.memory_max_mb"
        return Check("memory", "BAD", text)
    return Check("memory", "good", f"{there_mb} MB")


def clock(_: Settings) -> Check:
    """Wall clock: certificates, time stamps and the age of the history hang on it."""
    now = time.gmtime()
    if now.tm_year < EARLIEST_YEAR:
        return Check("clock", "BAD", f"it says {now.tm_year}; set it: timedatectl set-time, or a time server")
    if shutil.which("timedatectl"):
        asked = subprocess.run(
            ["timedatectl", "show", "--property=NTPSynchronized", "--value"],
            check=False,
            capture_output=True,
            text=True,
        )
        if asked.stdout.strip() == "no":
            return Check("clock", "note", "no time server sets it; its time stamps drift from those of the mill")
    return Check("clock", "good", time.strftime("%Y-%m-%d %H:%M:%S UTC", now))


def versions(_: Settings) -> Check:
    """Libraries against the versions that this software was made for."""
    wrong: list[str] = []
    for line in importlib.metadata.requires("hotgauge") or ():
        wanted, extra = line.partition(";")[::2]
        found = re.match(r"([\w.-]+)(.*)", wanted.strip())
        if found is None or extra:
            continue
        try:
            installed = importlib.metadata.version(found[1])
        except importlib.metadata.PackageNotFoundError:
            wrong.append(f"{found[1]} is missing")
            continue
        if not _fits(installed, found[2]):
            wrong.append(f"{found[1]} {installed} is not {found[2].strip()}")
    if wrong:
        return Check("versions", "BAD", f"{'; '.join(wrong)}; pip install --upgrade hotgauge")
    return Check("versions", "good", f"hotgauge {importlib.metadata.version('hotgauge')} and its libraries")


def _fits(installed: str, wanted: str) -> bool:
    """Whether a version lies within bounds such as `<2.6,>=2.2`."""
    version = _numbers(installed)
    for sign, bound in re.findall(r"(>=|<)\s*([\d.]+)", wanted):
        below = version < _numbers(bound)
        if below != (sign == "<"):
            return False
    return True


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(number) for number in re.findall(r"\d+", version)[:3])


FOR_THE_START: tuple[Callable[[Settings], Check], ...] = (scale, references, recordings, port, secure_port, versions)
"""Checks without which `run` refuses to start; `check-config` makes them, as any user and for a stopped gauge."""

FOR_GOOD_WORK: tuple[Callable[[Settings], Check], ...] = (delivery, disk, history, black_boxes, cache, memory, clock)
"""Checks of what the running gauge would report as a fault."""
