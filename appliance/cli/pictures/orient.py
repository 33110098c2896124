"""The command orient."""

import argparse
from pathlib import Path
from typing import get_args

from appliance.cli.common import add_config
from appliance.cli.outputs import (
    refuse_lost_input,
    refuse_other_formats,
    refuse_plots_among_inputs,
    refuse_unwritable,
)
from appliance.command_options import CommandError
from appliance.supervisor import settings as settings_file
from vision.ingot.classifiers.names import ClassifierName

CONFIRMATIONS = ("agreement", "top", "bottom")


def add_orient(command: argparse.ArgumentParser) -> None:
    command.add_argument("recording", type=Path, metavar="RECORDING", help="folder with the pictures of one camera")
    command.add_argument(
        "--references", type=Path, required=True, metavar="DIR", help="folder with top.png, bottom.png, roi.json"
    )
    command.add_argument(
        "--output",
        type=Path,
        required=True,
        metavar="FILE",
        help="frames and ingots as JSON lines; .csv: frames, and beside it NAME-ingots.csv",
    )
    command.add_argument("--classifier", choices=get_args(ClassifierName), help="how one picture is judged")
    command.add_argument("--plot", type=Path, metavar="DIR", help="folder for annotated frames and a strip of the ends")
    command.add_argument(
        "--learn",
        nargs="?",
        const="agreement",
        choices=CONFIRMATIONS,
        help="keep better references in DIR/learned, from ingots whose pictures agree, or which all show that end",
    )
    command.add_argument(
        "--use",
        type=int,
        metavar="NUMBER",
        help="first use that pair of DIR/learned again and forget confirmed ends; 0: top.png and bottom.png",
    )
    add_config(command)


def run_orient(given: argparse.Namespace) -> None:
    from appliance.ingot.learned_references import forget_confirmed, use
    from appliance.ingot.orient_recording import ingots_file, orient_recording

    refuse_other_formats(given.output)
    outputs = [given.output, *([ingots_file(given.output)] if given.output.suffix.lower() == ".csv" else [])]
    for output in outputs:
        refuse_lost_input(output, (given.recording, given.references, given.config))
        refuse_unwritable(output)
    refuse_plots_among_inputs(given.plot, (given.recording, given.references))
    settings = settings_file.load(given.config).ingot
    if given.classifier:
        settings = settings.model_copy(update={"classifier": given.classifier})
    try:
        if given.use is not None:
            use(given.references, given.use)
            forget_confirmed(given.references)
        lines = orient_recording(
            given.recording, given.references, given.output, settings, plot=given.plot, learn=given.learn
        )
    except OSError as error:
        place = error.filename or given.output
        raise CommandError(f"{place}: {error.strerror}; give a file in a writable folder") from error
    print("\n".join([*lines, f"written to {' and '.join(map(str, outputs))}"]))
