"""The command line: an error prints one sentence and gives exit code 2; image libraries load only when needed."""

import argparse
import difflib
import importlib.metadata
import io
import logging
import os
import re
import sys
import textwrap
import traceback
from collections.abc import Callable, Sequence
from typing import NoReturn

import shtab

from appliance.cli.common import add_config
from appliance.cli.examples import EXAMPLES
from appliance.cli.gauge import certificates, computer, history, page, plc, serve
from appliance.cli.pictures import (
    board,
    calibrate,
    capture,
    compare,
    fuse,
    measure,
    orient,
    plan,
    reproduce,
    simulate,
    train,
    verify,
)
from appliance.command_options import CommandError
from appliance.errors import HotgaugeError

HELP_COLUMNS = 79
EXIT_TROUBLE = 2
EXIT_INTERRUPTED = 130


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one sentence."""

    def error(self, message: str) -> NoReturn:
        words = message.replace("\n", " ").removeprefix("argument ")
        for kind, meaning in (("int", "whole number"), ("float", "number")):
            words = words.replace(f"invalid {kind} value: ", f"no {meaning}: ")
        words = words.replace("expected 2 arguments", "expected 2 arguments, with a blank between them")
        if decimal := re.search(r"'(-?\d+),(\d+)'", words):
            words += f"; decimals have a point: {decimal[1]}.{decimal[2]}"
        self.exit(EXIT_TROUBLE, f"hotgauge: {words}; see `{self.prog} --help`\n")

    def refuse(self, unknown: Sequence[str], command: str) -> NoReturn:
        """End with a sentence about words that the command does not know."""
        words = " ".join(unknown).replace("\n", " ")
        settings = [word for word in unknown if word.endswith(".toml")]
        if command == "check-config" and "--config" in unknown:
            advice = "give the file alone: hotgauge check-config FILE"
        elif settings:
            advice = f"settings are given as --config {settings[0]}"
        else:
            advice = "options begin with dashes, and a name with blanks stands in quotes"
        self.exit(EXIT_TROUBLE, f"hotgauge: {command} knows no {words}; {advice}; see `hotgauge {command} --help`\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : sequence of str or None
        Command line without the program's name; None takes the process's own.

    Returns
    -------
    int
        Exit code: 0 done, 1 a check of `doctor` has failed, 2 error, 130 interrupted.
    """
    _open_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a terminal that is not UTF-8 shows escapes for what it lacks
            stream.reconfigure(errors="backslashreplace")
    words = list(sys.argv[1:] if arguments is None else arguments)
    verbose = False
    try:
        given = _parsed(words)
        verbose = given.verbose
        if given.quiet:
            logging.getLogger("hotgauge").setLevel(logging.WARNING)
        exit_code = given.run(given)
        sys.stdout.flush()
    except HotgaugeError as error:
        if verbose:
            traceback.print_exc()
        _say(str(error))
        return EXIT_TROUBLE
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED
    except BrokenPipeError:  # the reader of a pipe has closed it, as `| head` does
        _give_up_output()
        return 0
    except OSError as error:
        _say_what_the_system_says(error)
        return EXIT_TROUBLE
    return exit_code or 0


def _open_closed_streams() -> None:
    """Lead standard streams that were closed (`>&-`) to nowhere; else the next file opened would get their numbers."""
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, io.TextIOWrapper(io.BufferedRandom(io.FileIO(os.devnull, "r+"))))


def _parsed(words: Sequence[str]) -> argparse.Namespace:
    _check_command(words[:1])
    whole = parser()
    given, unknown = whole.parse_known_args(words)
    if unknown:
        whole.refuse(unknown, given.command)
    return given


def _say(sentence: str) -> None:
    """Print one line, even if a file's name has several."""
    print("hotgauge: " + sentence.replace("\n", "\\n").replace("\r", "\\r"), file=sys.stderr)


def _say_what_the_system_says(error: OSError) -> None:
    if error.filename is not None:
        _say(f"{error.filename}: {error.strerror}; check the path and its permissions")
    elif isinstance(error, FileNotFoundError):
        _say("the folder that this shell is in is no longer there; change to another one")
    else:
        _give_up_output()
        _say(f"the output cannot be written: {error.strerror}; make room, or write elsewhere")


def _give_up_output() -> None:
    """Let what is still buffered for standard output go nowhere; the interpreter would try again at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _check_command(words: Sequence[str]) -> None:
    for word in words:
        if word in COMMANDS or word.startswith("-"):
            return
        near = difflib.get_close_matches(word, COMMANDS, n=1)
        advice = f"did you mean {near[0]}?" if near else "commands are " + ", ".join(COMMANDS)
        raise CommandError(f"there is no command {word}; {advice}")


def parser() -> _Parser:
    """Make the parser of all commands."""
    whole = _Parser(prog="hotgauge", description="Measures hot rolled bars and serves the PLC.")
    whole.add_argument("--version", action="version", version=f"hotgauge {importlib.metadata.version('hotgauge')}")
    loudness = whole.add_mutually_exclusive_group()
    loudness.add_argument("-v", "--verbose", action="store_true", help="show where in the program an error arose")
    loudness.add_argument("-q", "--quiet", action="store_true", help="no progress bar, and only warnings in the log")
    shtab.add_argument_to(whole, "--completion", help="print the completion of this shell and end")
    commands = whole.add_subparsers(metavar="COMMAND", required=True)
    for name, (run, text, add_arguments) in COMMANDS.items():
        command = commands.add_parser(
            name,
            help=text,
            description=textwrap.fill(f"{text}.", HELP_COLUMNS),
            epilog="\n".join(["examples:", *(f"  {example}" for example in EXAMPLES.get(name, ()))]),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        command.set_defaults(run=run, command=name)
        add_arguments(command)
    return whole


_Run = Callable[[argparse.Namespace], int | None]
_AddArguments = Callable[[argparse.ArgumentParser], None]

COMMANDS: dict[str, tuple[_Run, str, _AddArguments]] = {
    "run": (
        serve.run_gauge,
        "Measure and serve until stopped; without settings: the simulated mill",
        add_config,
    ),
    "replay": (serve.run_replay, "Measure and serve a recording, again and again, until stopped", serve.add_replay),
    "check-config": (
        computer.run_check_config,
        "Check a settings file and show what is in force",
        computer.add_check_config,
    ),
    "board": (board.run_board, "Write a checkerboard to print, with rulers that show its scale", board.add_board),
    "capture": (
        capture.run_capture,
        "Take pictures: of boards, the empty line, ingots, or a recording",
        capture.add_capture,
    ),
    "calibrate": (
        calibrate.run_calibrate,
        "Calibrate two cameras from pictures of a checkerboard",
        calibrate.add_calibrate,
    ),
    "measure": (measure.run_measure, "Measure a recording and write its readings to a file", measure.add_measure),
    "orient": (orient.run_orient, "Say which end of the ingots in a recording faces the line", orient.add_orient),
    "compare": (compare.run_compare, "Hold readings against the truth of their recording", compare.add_compare),
    "fuse": (fuse.run_fuse, "Fuse the two pictures of a pair into one and print its metrics", fuse.add_fuse),
    "reproduce": (
        reproduce.run_reproduce,
        "Run the dissertation's experiments again and write a report beside its figures",
        reproduce.add_reproduce,
    ),
    "simulate": (simulate.run_simulate, "Write a recording of the simulated mill, with truth", simulate.add_simulate),
    "export": (history.run_export, "Write what the history keeps of a time to CSV or Parquet", history.add_export),
    "report": (history.run_report, "Write pages about the shifts of a time, as HTML or PDF", history.add_report),
    "verify": (verify.run_verify, "Verify the gauge against a bar of known diameter", verify.add_verify),
    "gauge-study": (
        verify.run_gauge_study,
        "Repeatability and reproducibility of the gauge from repeated measurements",
        verify.add_gauge_study,
    ),
    "train-edges": (train.run_train_edges, "Train the forest that finds edges", train.add_train_edges),
    "registers": (plc.run_registers, "Print the register map", plc.add_registers),
    "install": (
        computer.run_install,
        "Set this computer up so that the gauge starts with it, as root",
        computer.add_install,
    ),
    "cameras": (computer.run_cameras, "List the cameras that are connected, of every kind", computer.add_cameras),
    "doctor": (computer.run_doctor, "Check settings, rig, cameras, port, service, disk and memory", add_config),
    "certificates": (
        certificates.run_certificates,
        "Make the certificates of the secure port and of its clients",
        certificates.add_certificates,
    ),
    "page": (page.run_page, "Show the gauge to people, in a browser, until stopped", add_config),
    "plan": (plan.run_plan, "Say what a mounting of two cameras would give, before anything is bought", plan.add_plan),
    "page-user": (page.run_page_user, "Let somebody log in to the page, or no more", page.add_page_user),
    "poll": (plc.run_poll, "Show a gauge's live values, as a PLC reads them", plc.add_poll),
}
