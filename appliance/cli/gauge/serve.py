"""Commands that measure and serve the PLC: run, replay."""

import argparse
import asyncio
import contextlib
import signal
import sys
from collections.abc import Callable
from pathlib import Path

from appliance.cli.common import add_config
from appliance.files.reload_request import was_asked_for_reload
from appliance.files.runtime_folder import give_runtime_folder
from appliance.service import systemd as service
from appliance.supervisor import settings as settings_file
from appliance.supervisor.settings import PlcSettings, Settings, state_folder
from appliance.supervisor.supervisor import Supervisor
from plc.registers import REGISTERS
from plc.security.addresses import EVERY, served_in_words

RELOAD_PERIOD_S = 1.0  # chosen


def run_gauge(given: argparse.Namespace) -> None:
    _serve(lambda: settings_file.load(given.config))


def add_replay(command: argparse.ArgumentParser) -> None:
    command.add_argument("recording", type=Path, metavar="RECORDING", help="folder with its pictures")
    command.add_argument("--rig", type=Path, help="calibration from `hotgauge calibrate`; method conveyor has none")
    add_config(command)


def run_replay(given: argparse.Namespace) -> None:
    def load() -> Settings:
        settings = settings_file.load(given.config)
        sizing = settings.sizing.with_recording(given.recording, given.rig)
        return settings.model_copy(update={"sizing": sizing})

    _serve(load)


def _serve(load: Callable[[], Settings]) -> None:
    settings = load()
    give_runtime_folder(settings.plc.port)
    service.start_log()
    asyncio.run(_supervise(settings, load))


async def _supervise(settings: Settings, load: Callable[[], Settings]) -> None:
    supervisor = Supervisor(settings)
    manager = service.ServiceManager()
    loop = asyncio.get_running_loop()
    reloads: set[asyncio.Task[None]] = set()  # keeps the tasks: the loop holds only weak references

    def stop() -> None:
        manager.stopping()
        supervisor.stop()

    def reload() -> None:
        task = loop.create_task(supervisor.reload(load))
        reloads.add(task)
        task.add_done_callback(reloads.discard)

    def serving(port: int) -> None:
        manager.ready()
        with contextlib.suppress(OSError):  # a full disk, or a reader that has gone, is no trouble of the gauge
            service.write_unblocked(sys.stdout.fileno(), "\n".join(welcome(settings, port)))

    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, stop)
    loop.add_signal_handler(signal.SIGUSR1, supervisor.keep_pictures)
    managed = service.is_managed()
    if managed:  # without a service manager SIGHUP means that the terminal was closed
        loop.add_signal_handler(signal.SIGHUP, reload)
    asked = loop.create_task(_reload_when_asked(reload))
    reloads.add(asked)
    # a service serves the fault to the PLC instead of refusing to start, since nobody reads its terminal
    await supervisor.run(serving, manager.proof, refuses=not managed)


async def _reload_when_asked(reload: Callable[[], None]) -> None:
    """Reload when the page asks for it; its process has no other way to, and should have none."""
    while True:
        await asyncio.sleep(RELOAD_PERIOD_S)
        if was_asked_for_reload():
            reload()


def welcome(settings: Settings, port: int) -> list[str]:
    """Lines that `hotgauge run` prints once the port answers.

    Parameters
    ----------
    settings : Settings
    port : int
        TCP port that is served.
    """
    address = next(row.address for row in REGISTERS if row.name == "diameter")
    host = "127.0.0.1" if settings.plc.host in {"0.0.0.0", "::"} else settings.plc.host  # noqa: S104
    order = " -B" if settings.plc.word_order == "big" else ""
    source = settings.sizing.camera.in_words
    lines = [
        f"Hotgauge measures {source} and serves Modbus TCP on {_place(settings.plc, port)}",
        "  register map     hotgauge registers --format markdown",
        "  stop             Ctrl-C",
    ]
    if settings.plc.plain:
        lines[1:1] = [
            f"  live values      hotgauge poll {host} --port {port}",
            f"  diameter, in mm  mbpoll -m tcp -a 1 -p {port} -0 -1 -t 3:float{order} -r {address} {host}",
        ]
    if settings.plc.host == EVERY:
        lines.append(f"  served           {served_in_words(EVERY)}")
    if settings.plc.writes != "none" and state_folder(settings.plc) is None:
        lines.append("  set points       kept in memory only; set plc.state_directory to keep them over a restart")
    return lines


def _place(plc: PlcSettings, port: int) -> str:
    """Where the server listens, with every port."""
    host = f"[{plc.host}]" if ":" in plc.host else plc.host
    plain = [f"{host}:{port}"] if plc.plain else []
    secure = [f"{host}:{plc.tls.port} with TLS"] if plc.tls.files is not None else []
    return " and ".join(plain + secure)
