"""Commands that serve the PLC or look at a gauge and its computer."""

import argparse
import asyncio
import itertools
import signal
from collections.abc import Callable
from pathlib import Path

from appliance import service
from appliance import settings as settings_file
from appliance.camera_settings import RecordedPictures, RecordingCamera
from appliance.commands.common import CommandError, add_config, whole_number
from appliance.kept import state_folder
from appliance.settings import PlcSettings, Settings
from appliance.sizing_settings import ConveyorSettings, SizingSettings
from appliance.supervisor import StartRefusedError, Supervisor
from plc.registers import REGISTERS

EXIT_CHECKS_FAILED = 1


def run_gauge(given: argparse.Namespace) -> None:
    _serve(lambda: settings_file.load(given.config))


def add_replay(command: argparse.ArgumentParser) -> None:
    command.add_argument("recording", type=Path, metavar="RECORDING", help="folder with its pictures")
    command.add_argument("--rig", type=Path, help="calibration from `hotgauge calibrate`; method conveyor has none")
    add_config(command)


def run_replay(given: argparse.Namespace) -> None:
    def load() -> Settings:
        settings = settings_file.load(given.config)
        sizing = _replayed(settings.sizing, given.recording, given.rig)
        return settings.model_copy(update={"sizing": sizing})

    _serve(load)


def _replayed(
    sizing: SizingSettings | ConveyorSettings, recording: Path, rig: Path | None
) -> SizingSettings | ConveyorSettings:
    """Settings with a recording in place of the camera."""
    if isinstance(sizing, ConveyorSettings):
        if rig is not None:
            raise CommandError('--rig: sizing.method = "conveyor" has none; leave it out')
        return sizing.model_copy(update={"camera": RecordedPictures(kind="recording", path=recording)})
    if rig is None:
        raise CommandError("--rig: the rig file of these cameras is missing; make it with hotgauge calibrate")
    return sizing.model_copy(update={"camera": RecordingCamera(kind="recording", path=recording), "rig": rig})


def _serve(load: Callable[[], Settings]) -> None:
    settings = load()
    service.start_log()
    try:
        asyncio.run(_supervise(settings, load))
    except StartRefusedError as error:
        raise CommandError(str(error)) from error


async def _supervise(settings: Settings, load: Callable[[], Settings]) -> None:
    supervisor = Supervisor(settings)
    manager = service.ServiceManager()
    loop = asyncio.get_running_loop()
    reloads: set[asyncio.Task[None]] = set()  # the loop itself holds tasks only weakly

    def stop() -> None:
        manager.stopping()
        supervisor.stop()

    def reload() -> None:
        task = loop.create_task(supervisor.reload(load))
        reloads.add(task)
        task.add_done_callback(reloads.discard)

    def serving(port: int) -> None:
        manager.ready()
        print("\n".join(welcome(settings, port)), flush=True)

    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, stop)
    managed = service.is_managed()
    if managed:  # on a terminal it means that the terminal is closed
        loop.add_signal_handler(signal.SIGHUP, reload)
    # a service has nobody who looks at a refusal: it serves the fault instead
    await supervisor.run(serving, manager.proof, refuses=not managed)


def welcome(settings: Settings, port: int) -> list[str]:
    address = next(row.address for row in REGISTERS if row.name == "diameter")
    host = "127.0.0.1" if settings.plc.host in {"0.0.0.0", "::"} else settings.plc.host  # noqa: S104
    order = " -B" if settings.plc.word_order == "big" else ""
    source = _source_in_words(settings.sizing)
    lines = [
        f"Hotgauge measures {source} and serves Modbus TCP on {settings.plc.host}:{port}",
        f"  live values      hotgauge poll {host} --port {port}",
        f"  diameter, in mm  mbpoll -m tcp -a 1 -p {port} -0 -1 -t 3:float{order} -r {address} {host}",
        "  register map     hotgauge registers --format markdown",
        "  stop             Ctrl-C",
    ]
    if settings.plc.writes != "none" and state_folder(settings.plc) is None:
        lines.append("  set points       kept in memory only; set plc.state_directory to keep them over a restart")
    return lines


PAIRS = {"mill": "the simulated mill", "oak": "OAK cameras", "stream": "two streams"}
SINGLE = {"mill": "the simulated thermal line", "oak": "an OAK camera", "stream": "a stream"}


def _source_in_words(sizing: SizingSettings | ConveyorSettings) -> str:
    camera = sizing.camera
    if isinstance(camera, (RecordingCamera, RecordedPictures)):
        return f"the recording {camera.path}"
    return (SINGLE if isinstance(sizing, ConveyorSettings) else PAIRS)[camera.kind]


def add_check_config(command: argparse.ArgumentParser) -> None:
    command.add_argument("config", type=Path, nargs="?", metavar="FILE", help="settings in TOML")


def run_check_config(given: argparse.Namespace) -> None:
    settings = settings_file.load(given.config)
    print(f"# {given.config or 'the defaults'}: good; in force:")
    for row, value in settings_file.in_force(settings):
        print(f"{row.key} = {value}  # {row.allowed}; {row.text}" if value else f"# {row.key}  # {row.text}")


def add_poll(command: argparse.ArgumentParser) -> None:
    port = PlcSettings.model_fields["port"].default
    command.add_argument("host", metavar="HOST", help="name or address of the gauge")
    command.add_argument("--port", type=int, default=port, help=f"TCP port, {port} unless given")
    command.add_argument("--count", type=whole_number, help="number of polls; without: until Ctrl-C")
    command.add_argument("--word-order", choices=("big", "little"), default="big", help="as set in the gauge")


def run_poll(given: argparse.Namespace) -> None:
    from plc.client import PollError, poll, snapshot_lines

    try:
        snapshots = poll(given.host, given.port, word_order=given.word_order)
        for snapshot in itertools.islice(snapshots, given.count):
            print("\n".join(snapshot_lines(snapshot)), end="\n\n", flush=True)
    except PollError as error:
        raise CommandError(str(error)) from error


def add_install(command: argparse.ArgumentParser) -> None:
    command.add_argument("--remove", action="store_true", help="take the service down again instead")
    command.add_argument("--root", type=Path, default=Path("/"), metavar="DIR", help="write below this folder only")


def run_install(given: argparse.Namespace) -> None:
    from appliance.install import InstallError, install, remove

    try:
        for line in (remove if given.remove else install)(given.root):
            print(line)
    except InstallError as error:
        raise CommandError(str(error)) from error


def run_doctor(given: argparse.Namespace) -> int | None:
    from appliance.doctor import examine
    from appliance.install import CONFIG

    installed = Path("/") / CONFIG
    config = given.config or (installed if installed.is_file() else None)
    bad = 0
    for check in examine(config):
        print(check, flush=True)
        bad += check.verdict == "BAD"
    return EXIT_CHECKS_FAILED if bad else None
