"""Options of `measure` that choose the dissertation's ways: as printed, corrections by name, its numbers, its edges."""

import argparse
from pathlib import Path

from vision.edges.names import CANNY_KERNELS, EDGE_METHODS

NUMBERS = (
    ("alpha", float, "A", "factor on Otsu's threshold of the picture, algorithm 8"),
    ("beta", float, "B", "least edge strength, 1 to 255, algorithm 8"),
    ("least_neighbours", int, "N", "edge pixels around one that is kept, algorithm 4"),
    ("window_rows", int, "H", "rows of a window, algorithm 9"),
    ("sample_points", int, "S", "points of a sample, algorithm 9"),
    ("sample_count", int, "T", "samples of a window, algorithm 9"),
    ("boards", int, "N", "virtual boards that are searched, algorithm 13"),
)
PRINTED_OPTIONS = (
    *("as_printed", "correct", "edges", "edge_model", "canny_low", "canny_high", "canny_kernel"),
    *(name for name, _, _, _ in NUMBERS),
)


def add_route_options(command: argparse.ArgumentParser) -> None:
    """Declare them."""
    group = command.add_argument_group("of virtual-board and one-camera")
    group.add_argument("--edges", metavar="NAME", help=f"{', '.join(EDGE_METHODS)}; forest unless given")
    group.add_argument(
        "--edge-model", type=Path, metavar="FILE", help="forest from hotgauge train-edges; else the shipped one"
    )
    group.add_argument("--canny-low", type=float, metavar="SHARE", help="of the steepest gradient; 0.02 unless given")
    group.add_argument("--canny-high", type=float, metavar="SHARE", help="of the steepest gradient; 0.05 unless given")
    group.add_argument("--canny-kernel", metavar="NAME", help=f"{', '.join(CANNY_KERNELS)} (eq. 2.5 and 2.6)")
    group.add_argument("--as-printed", action="store_true", default=None, help="as the dissertation prints it")
    group.add_argument(
        "--correct",
        action="append",
        metavar="NAME",
        help="with --as-printed, a correction that is made all the same: turned-rows, robust-lines, "
        "projective-boards, tangent-crossing, half-level; repeatable",
    )
    for name, kind, symbol, text in NUMBERS:
        group.add_argument(f"--{name.replace('_', '-')}", type=kind, metavar=symbol, help=text)
