"""The command line: trouble is one sentence and exit code 2; only commands that need pictures load image libraries."""

import argparse
import asyncio
import contextlib
import difflib
import itertools
import os
import signal
import sys
from collections.abc import Callable, Generator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from appliance import service
from appliance import settings as settings_file
from appliance.kept import state_folder
from appliance.settings import PlcSettings, RecordingCamera, Settings
from appliance.supervisor import StartRefusedError, Supervisor
from plc import export
from plc.registers import REGISTERS

if TYPE_CHECKING:
    from vision.edges.operators import EdgeMethod

EXIT_CHECKS_FAILED = 1
EXIT_TROUBLE = 2
EXIT_INTERRUPTED = 130

PATCHES = 40_000  # of each tree of the edge forest


class CommandError(Exception):
    """The command cannot do what it was asked for; the message says what, where and what to do."""


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one sentence."""

    def error(self, message: str) -> NoReturn:
        self.exit(EXIT_TROUBLE, f"hotgauge: {message}; see `{self.prog} --help`\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : sequence of str or None
        Command line without the program's name; None takes the process's own.

    Returns
    -------
    int
        Exit code: 0 done, 1 checks have failed, 2 trouble, 130 interrupted.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        _check_command(words[:1])
        given = parser().parse_args(words)
        exit_code = given.run(given)
        sys.stdout.flush()
    except (CommandError, settings_file.SettingsError) as error:
        print(f"hotgauge: {error}", file=sys.stderr)
        return EXIT_TROUBLE
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED
    except BrokenPipeError:  # `hotgauge registers | head` is nobody's error
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return exit_code or 0


def _check_command(words: Sequence[str]) -> None:
    for word in words:
        if word in COMMANDS or word.startswith("-"):
            return
        near = difflib.get_close_matches(word, COMMANDS, n=1)
        advice = f"did you mean {near[0]}?" if near else "commands are " + ", ".join(COMMANDS)
        raise CommandError(f"there is no command {word}; {advice}")


def parser() -> argparse.ArgumentParser:
    """The whole command line."""
    whole = _Parser(prog="hotgauge", description="Measures hot rolled bars and serves the PLC.")
    commands = whole.add_subparsers(metavar="COMMAND", required=True)
    for name, (run, text, add_arguments) in COMMANDS.items():
        command = commands.add_parser(name, help=text, description=f"{text}.")
        command.set_defaults(run=run)
        add_arguments(command)
    return whole


def _add_config(command: argparse.ArgumentParser) -> None:
    command.add_argument("--config", type=Path, metavar="FILE", help="settings in TOML; without: the defaults")


def _add_recording_and_rig(command: argparse.ArgumentParser) -> None:
    command.add_argument("recording", type=Path, metavar="RECORDING", help="folder with left and right pictures")
    command.add_argument("--rig", type=Path, required=True, help="calibration from `hotgauge calibrate`")


def _run(given: argparse.Namespace) -> None:
    _serve(lambda: settings_file.load(given.config))


def _add_replay(command: argparse.ArgumentParser) -> None:
    _add_recording_and_rig(command)
    _add_config(command)


def _replay(given: argparse.Namespace) -> None:
    def load() -> Settings:
        settings = settings_file.load(given.config)
        camera = RecordingCamera(kind="recording", path=given.recording)
        sizing = settings.sizing.model_copy(update={"camera": camera, "rig": given.rig})
        return settings.model_copy(update={"sizing": sizing})

    _serve(load)


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
        print("\n".join(_welcome(settings, port)), flush=True)

    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, stop)
    managed = service.is_managed()
    if managed:  # on a terminal it means that the terminal is closed
        loop.add_signal_handler(signal.SIGHUP, reload)
    # a service has nobody who looks at a refusal: it serves the fault instead
    await supervisor.run(serving, manager.proof, refuses=not managed)


def _welcome(settings: Settings, port: int) -> list[str]:
    address = next(row.address for row in REGISTERS if row.name == "diameter")
    host = "127.0.0.1" if settings.plc.host in {"0.0.0.0", "::"} else settings.plc.host  # noqa: S104
    order = " -B" if settings.plc.word_order == "big" else ""
    camera = settings.sizing.camera
    source = f"the recording {camera.path}" if isinstance(camera, RecordingCamera) else "the simulated mill"
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


def _add_check_config(command: argparse.ArgumentParser) -> None:
    command.add_argument("config", type=Path, nargs="?", metavar="FILE", help="settings in TOML")


def _check_config(given: argparse.Namespace) -> None:
    settings = settings_file.load(given.config)
    print(f"# {given.config or 'the defaults'}: good; in force:")
    for row, value in settings_file.in_force(settings):
        print(f"{row.key} = {value}  # {row.allowed}; {row.text}" if value else f"# {row.key}  # {row.text}")


def _add_measure(command: argparse.ArgumentParser) -> None:
    _add_recording_and_rig(command)
    command.add_argument(
        "--output", type=Path, required=True, metavar="FILE", help="readings; CSV if it ends in .csv, else JSON lines"
    )
    command.add_argument(
        "--method",
        choices=("tangent", "virtual-board"),
        default="tangent",
        help="route to the diameter, tangent unless given; virtual-board is the dissertation's, on its own",
    )
    command.add_argument("--edges", metavar="NAME", help="edge detector of virtual-board, forest unless given")
    command.add_argument("--plot", type=Path, metavar="DIR", help="folder for plots of virtual-board")


def _measure(given: argparse.Namespace) -> None:
    from appliance.cameras.source import CameraError
    from appliance.measure import measure_recording
    from appliance.plots import PlotsMissingError
    from appliance.rigs import RigError

    for option in ("edges", "plot"):
        if given.method == "tangent" and getattr(given, option) is not None:
            raise CommandError(f"--{option}: only virtual boards have it; add --method virtual-board")
    edges = _edge_method(given.edges or "forest")
    try:
        measure_recording(given.recording, given.rig, given.output, method=given.method, edges=edges, plots=given.plot)
    except (CameraError, RigError, PlotsMissingError) as error:
        raise CommandError(str(error)) from error
    except OSError as error:
        path = error.filename or given.output
        raise CommandError(f"{path}: {error.strerror}; give a place in a writable folder") from error


def _edge_method(name: str) -> "EdgeMethod":
    from vision.edges.operators import EDGE_METHODS

    for known in EDGE_METHODS:
        if name == known:
            return known
    near = difflib.get_close_matches(name, EDGE_METHODS, n=1)
    advice = f"did you mean {near[0]}?" if near else "there are " + ", ".join(EDGE_METHODS)
    raise CommandError(f"--edges: there is no edge detector {name}; {advice}")


_BOARD_NUMBERS = ("square_mm", "square_u_mm", "low_mm", "high_mm", "height_u_mm")


def _add_calibrate(command: argparse.ArgumentParser) -> None:
    command.add_argument("folder", type=Path, metavar="DIR", help="rig folder: pictures of the board, board.json")
    command.add_argument("--output", type=Path, required=True, metavar="FILE", help="rig file to write")
    region = command.add_argument("--region", type=float, nargs=2, default=(-250.0, 250.0), metavar=("FROM", "TO"))
    region.help = "measuring region along the rolling direction, mm; -250 250 unless given"
    board = command.add_argument_group("in place of what board.json says")
    board.add_argument("--squares", type=int, nargs=2, metavar=("LONG", "SHORT"))
    for name in _BOARD_NUMBERS:
        board.add_argument(f"--{name.replace('_', '-')}", type=float, metavar="MM")
    board.add_argument("--response", choices=("srgb", "linear", "gamma 2.2"))


def _calibrate(given: argparse.Namespace) -> None:
    from appliance.calibrate import calibrate_folder, report_lines
    from appliance.rigs import RigError, save_rig
    from vision.calibration.verdict import CalibrationError

    board = {name: getattr(given, name) for name in ("squares", *_BOARD_NUMBERS, "response")}
    overrides = {name: value for name, value in board.items() if value is not None}
    try:
        with _progress("picture pair") as progress:
            calibration = calibrate_folder(given.folder, overrides, tuple(given.region), progress)
        save_rig(calibration.rig, given.output)
    except (CalibrationError, RigError) as error:
        raise CommandError(str(error)) from error
    print("\n".join([*report_lines(calibration), f"written to    {given.output}"]))


@contextlib.contextmanager
def _progress(unit: str) -> Generator[Callable[[int, int], None]]:
    """A progress bar on a terminal, nothing on a pipe; gets how many are done, of how many."""
    from tqdm import tqdm

    with tqdm(unit=unit, disable=None) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield show


def _add_simulate(command: argparse.ArgumentParser) -> None:
    command.add_argument("--output", type=Path, required=True, metavar="DIR", help="new folder for the recording")
    command.add_argument(
        "--scene", default="line", metavar="NAME", help="line (bars passing), thermal, or a condition such as clean"
    )
    command.add_argument(
        "--effect",
        action="append",
        default=[],
        metavar="NAME",
        help="added to a condition, such as ovality; repeatable",
    )
    command.add_argument("--seed", type=_whole_number, default=1, help="seed of all that is drawn, 1 unless given")
    command.add_argument("--frames", type=_whole_number, default=50, help="frames, 50 unless given")


def _whole_number(text: str) -> int:
    number = int(text)
    if number < 0:
        raise ValueError
    return number


def _simulate(given: argparse.Namespace) -> None:
    from appliance.mill.writer import OutputError

    try:
        with _progress("picture") as on_progress:
            if given.scene == "thermal":
                _write_thermal(given)
            else:
                _write_stereo(given, on_progress)
    except OutputError as error:
        raise CommandError(str(error)) from error
    print(f"{given.output}: {given.frames} frames of the scene {given.scene}, with truth")
    if given.scene != "thermal":
        print(f"  next: hotgauge calibrate {given.output} --output rig.json")


def _write_thermal(given: argparse.Namespace) -> None:
    from appliance.mill.thermal import random_thermal_line
    from appliance.mill.writer import write_thermal_recording

    if given.effect:
        raise CommandError("--effect: a thermal scene has none; leave it out")
    write_thermal_recording(given.output, random_thermal_line(given.seed), frames=given.frames)


def _write_stereo(given: argparse.Namespace, on_progress: Callable[[int, int], None]) -> None:
    from appliance.mill.scenes import CONDITIONS
    from appliance.mill.writer import write_line, write_scene

    if given.scene == "line" and not given.effect:
        write_line(given.output, given.seed, given.frames, on_progress=on_progress)
        return
    try:
        write_scene(given.output, given.scene, given.seed, given.frames, effects=given.effect, on_progress=on_progress)
    except ValueError as error:
        known = {
            kind: ", ".join(row.name for row in CONDITIONS if row.kind == kind) for kind in ("condition", "effect")
        }
        raise CommandError(
            f"{error}; scenes are line, thermal and the conditions {known['condition']}; effects are {known['effect']}"
        ) from error


def _add_train_edges(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--bsds", type=Path, metavar="DIR", help="folder in BSDS500's layout; without: our own rendered scenes"
    )
    command.add_argument("--output", type=Path, required=True, metavar="FILE", help="model to write, ending in .npz")
    command.add_argument("--seed", type=_whole_number, default=1, help="seed of all that is drawn, 1 unless given")
    command.add_argument("--patches", type=_whole_number, default=PATCHES, help=f"of each tree, {PATCHES} unless given")


def _train_edges(given: argparse.Namespace) -> None:
    from appliance.train_edges import BsdsSource, SceneSource, TrainingError, check_output, train, write

    command = f"hotgauge train-edges --output {given.output.name} --seed {given.seed} --patches {given.patches}"
    try:
        check_output(given.output)
        source = SceneSource() if given.bsds is None else BsdsSource(given.bsds)
        with _progress("patch") as progress:
            forest, record = train(source, given.seed, given.patches, command, progress)
        write(forest, record, given.output)
    except TrainingError as error:
        raise CommandError(str(error)) from error
    minutes, seconds = divmod(round(record.cpu_seconds), 60)
    print(f"forest        {record.trees} trees of {record.patches_per_tree} patches, {record.nodes} nodes in all")
    print(f"time, memory  {minutes} min {seconds} s of one core, {record.peak_memory_mb} MB")
    print(f"written to    {given.output}, and how it was made to {given.output.with_suffix('.json')}")


def _add_registers(command: argparse.ArgumentParser) -> None:
    command.add_argument("--format", choices=("markdown", "csv", "json", "st"), default="markdown")


def _registers(given: argparse.Namespace) -> None:
    texts = {
        "markdown": export.to_markdown,
        "csv": export.to_csv,
        "json": export.to_json,
        "st": export.to_structured_text,
    }
    sys.stdout.write(texts[given.format]())


def _add_poll(command: argparse.ArgumentParser) -> None:
    port = PlcSettings.model_fields["port"].default
    command.add_argument("host", metavar="HOST", help="name or address of the gauge")
    command.add_argument("--port", type=int, default=port, help=f"TCP port, {port} unless given")
    command.add_argument("--count", type=_whole_number, help="number of polls; without: until Ctrl-C")
    command.add_argument("--word-order", choices=("big", "little"), default="big", help="as set in the gauge")


def _poll(given: argparse.Namespace) -> None:
    from plc.client import PollError, poll, snapshot_lines

    try:
        snapshots = poll(given.host, given.port, word_order=given.word_order)
        for snapshot in itertools.islice(snapshots, given.count):
            print("\n".join(snapshot_lines(snapshot)), end="\n\n", flush=True)
    except PollError as error:
        raise CommandError(str(error)) from error


def _add_install(command: argparse.ArgumentParser) -> None:
    command.add_argument("--remove", action="store_true", help="take the service down again instead")
    command.add_argument("--root", type=Path, default=Path("/"), metavar="DIR", help="write below this folder only")


def _install(given: argparse.Namespace) -> None:
    from appliance.install import InstallError, install, remove

    try:
        for line in (remove if given.remove else install)(given.root):
            print(line)
    except InstallError as error:
        raise CommandError(str(error)) from error


def _doctor(given: argparse.Namespace) -> int | None:
    from appliance.doctor import examine
    from appliance.install import CONFIG

    installed = Path("/") / CONFIG
    config = given.config or (installed if installed.is_file() else None)
    bad = 0
    for check in examine(config):
        print(check, flush=True)
        bad += check.verdict == "BAD"
    return EXIT_CHECKS_FAILED if bad else None


_Run = Callable[[argparse.Namespace], int | None]
_AddArguments = Callable[[argparse.ArgumentParser], None]

COMMANDS: dict[str, tuple[_Run, str, _AddArguments]] = {
    "run": (_run, "Measure and serve until stopped; without settings: the simulated mill", _add_config),
    "replay": (_replay, "Measure and serve a recording, again and again, until stopped", _add_replay),
    "check-config": (_check_config, "Check a settings file and show what is in force", _add_check_config),
    "calibrate": (_calibrate, "Calibrate two cameras from pictures of a checkerboard", _add_calibrate),
    "measure": (_measure, "Measure a recording and write its readings to a file", _add_measure),
    "simulate": (_simulate, "Write a recording of the simulated mill, with truth", _add_simulate),
    "train-edges": (_train_edges, "Train the forest that finds edges", _add_train_edges),
    "registers": (_registers, "Print the register map", _add_registers),
    "install": (_install, "Set this computer up so that the gauge starts with it, as root", _add_install),
    "doctor": (_doctor, "Check settings, rig, cameras, port, service, disk and memory", _add_config),
    "poll": (_poll, "Show a gauge's live values, as a PLC reads them", _add_poll),
}
