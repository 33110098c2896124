"""The command train-edges."""

import argparse
from pathlib import Path

from appliance.cli.common import progress, whole_number

PATCHES = 40_000  # chosen: training patches for each tree of the edge forest


def add_train_edges(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--bsds", type=Path, metavar="DIR", help="folder in BSDS500's layout; without: our own rendered scenes"
    )
    command.add_argument("--output", type=Path, required=True, metavar="FILE", help="model to write, ending in .npz")
    command.add_argument("--seed", type=whole_number, default=1, help="seed of all that is drawn, 1 unless given")
    command.add_argument("--patches", type=whole_number, default=PATCHES, help=f"of each tree, {PATCHES} unless given")
    command.add_argument(
        "--criterion", choices=("gini", "entropy"), default="gini", help="purity of a split; gini unless given"
    )


def run_train_edges(given: argparse.Namespace) -> None:
    from appliance.training.edge_forest import BsdsSource, SceneSource, check_output, train, write

    command = f"hotgauge train-edges --output {given.output.name} --seed {given.seed} --patches {given.patches}"
    if given.criterion != "gini":
        command += f" --criterion {given.criterion}"
    check_output(given.output)
    source = SceneSource() if given.bsds is None else BsdsSource(given.bsds)
    with progress("patch") as show:
        forest, record = train(source, given.seed, given.patches, command, show, criterion=given.criterion)
    write(forest, record, given.output)
    minutes, seconds = divmod(round(record.cpu_seconds), 60)
    print(f"forest        {record.trees} trees of {record.patches_per_tree} patches, {record.nodes} nodes in all")
    print(f"time, memory  {minutes} min {seconds} s of one core, {record.peak_memory_mb} MB")
    print(f"written to    {given.output}, and how it was made to {given.output.with_suffix('.json')}")
