"""The command measure for a folder of recordings: its options, one recording in a worker, and what is said."""

import argparse
import hashlib
import importlib.metadata
import json
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from appliance.cli.common import positive_number, progress
from appliance.command_options import CommandError
from appliance.errors import HotgaugeError

EXIT_SOME_FAILED = 1
DECIDES_NOTHING = frozenset({"run", "command", "recording", "output", "processes", "dask"})


def add_archive(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("of a folder of recordings, into one .parquet")
    group.add_argument("--processes", type=positive_number, metavar="N", help="on this computer; one a processor")
    group.add_argument("--dask", metavar="ADDRESS", help="scheduler of a Dask cluster that sees the same files")


def run_archive(given: argparse.Namespace, run: Callable[[argparse.Namespace], list[str]]) -> int | None:
    """Measure a folder of recordings.

    Parameters
    ----------
    given : Namespace
    run : callable
        Measures one recording as the options say; a function of a module, which other processes import.
    """
    from appliance.archives.measure_archive import measure_archive
    from appliance.sizing.reading_rows import COLUMNS

    if given.plot is not None:
        raise CommandError("--plot: a folder of recordings has none; measure a single recording")
    with progress("recording") as show:
        found = measure_archive(
            given.recording,
            given.output,
            partial(measure_one, given, run),
            deciding_options(given),
            columns=COLUMNS,
            processes=given.processes,
            dask=given.dask,
            show=show,
        )
    reasons = set(found.failed.values())
    if len(found.failed) == found.recordings and len(reasons) == 1:
        raise CommandError(reasons.pop())
    counts = f"{found.frames} frames of {found.recordings} recordings, {found.resumed} of them measured before"
    print(f"{given.output}: {counts}")
    for name, why in found.failed.items():
        print(f"hotgauge: {name}: {why}", file=sys.stderr)
    return EXIT_SOME_FAILED if found.failed else None


def measure_one(
    given: argparse.Namespace, run: Callable[[argparse.Namespace], list[str]], recording: Path
) -> list[dict[str, Any]]:
    """Measure one recording in a worker; one that cannot be measured is a row that says why.

    Parameters
    ----------
    given : Namespace
    run : callable
    recording : Path
    """
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "rows.jsonl"
        try:
            run(argparse.Namespace(**vars(given) | {"recording": recording, "output": output}))
            lines = output.read_text(encoding="utf-8").splitlines()
        except (HotgaugeError, OSError) as error:
            return [{"frame": None, "error": str(error)}]
        return [json.loads(line) for line in lines]


def deciding_options(given: argparse.Namespace) -> dict[str, str]:
    """All that decides a value beside a recording: the version, options, and the content of files that they name."""
    options = {name: value for name, value in vars(given).items() if name not in DECIDES_NOTHING}
    return {"version": importlib.metadata.version("hotgauge")} | {
        name: hashlib.sha256(value.read_bytes()).hexdigest()
        if isinstance(value, Path) and value.is_file()
        else str(value)
        for name, value in options.items()
    }
