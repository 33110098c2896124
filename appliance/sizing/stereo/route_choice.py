"""Makes the gauge that a command line of `measure` asks for."""

import argparse
from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial

from appliance.command_options import CommandError, one_of
from appliance.sizing.stereo.edge_model import load_edge_model
from appliance.sizing.stereo.gauge import Measures
from appliance.sizing.stereo.route_options import NUMBERS
from vision.calibration.rig import Rig
from vision.edges.names import CANNY_KERNELS, EDGE_METHODS
from vision.edges.operators import EdgeOptions
from vision.fusion.names import FUSIONS
from vision.readings import SizeReading
from vision.sizing.gauge import Gauge
from vision.sizing.virtual_board.gauge import VirtualBoardGauge
from vision.sizing.virtual_board.one_camera import SIDES, OneCameraGauge
from vision.sizing.virtual_board.parameters import PRINTED_PARAMETERS, SERVED_PARAMETERS, Parameters
from vision.sizing.virtual_board.reading import AS_PRINTED, CORRECTED, Corrections, VirtualBoardReading


def edge_options(given: argparse.Namespace) -> EdgeOptions:
    """Edge detector of a command line; raises `CommandError` and `EdgeModelError`."""
    method = one_of(EDGE_METHODS, given.edges or "forest", "--edges")
    canny = {name: getattr(given, name) for name in ("canny_low", "canny_high", "canny_kernel")}
    canny = {name: value for name, value in canny.items() if value is not None}
    if canny and method != "canny":
        raise CommandError(f"--{next(iter(canny)).replace('_', '-')}: only canny has it; add --edges canny")
    if given.edge_model is not None and method != "forest":
        raise CommandError(f"--edge-model: {method} has none; leave it out, or --edges")
    if "canny_kernel" in canny:
        canny["canny_kernel"] = one_of(CANNY_KERNELS, canny["canny_kernel"], "--canny-kernel")
    forest = None if given.edge_model is None else load_edge_model(given.edge_model)
    try:
        return EdgeOptions(method=method, forest=forest, **canny)
    except ValueError as error:
        raise CommandError(f"--canny-low, --canny-high: {error}") from error


def corrections(given: argparse.Namespace) -> Corrections:
    """Corrections of a command line; raises `CommandError`."""
    if not given.as_printed:
        if given.correct:
            raise CommandError("--correct: without --as-printed every correction is made; add --as-printed")
        return CORRECTED
    known = [field.name.replace("_", "-") for field in fields(Corrections)]
    chosen = {one_of(known, name, "--correct").replace("-", "_"): True for name in given.correct or ()}
    try:
        return replace(AS_PRINTED, **chosen)
    except ValueError as error:
        raise CommandError(f"--correct: {error}".replace("_", "-")) from error


def parameters(given: argparse.Namespace, corrected: Corrections) -> Parameters:
    """Numbers of a command line, else those that belong to the corrections; raises `CommandError`."""
    usual = SERVED_PARAMETERS if corrected.robust_lines else PRINTED_PARAMETERS
    chosen = {name: getattr(given, name) for name, _, _, _ in NUMBERS if getattr(given, name) is not None}
    try:
        return replace(usual, **chosen)
    except ValueError as error:
        raise CommandError(f"--{error}".replace("_", "-")) from error


def gauge_of(given: argparse.Namespace) -> Callable[[Rig], Measures[SizeReading | VirtualBoardReading]]:
    """What makes the gauge of a command line from a rig."""
    if given.method == "tangent":
        return partial(Gauge, ovality_mm=given.ovality)
    corrected = corrections(given)
    shared = {"corrections": corrected, "edges": edge_options(given), "parameters": parameters(given, corrected)}
    if given.method == "virtual-board":
        return partial(VirtualBoardGauge, fusion=one_of(FUSIONS, given.fusion or "none", "--fusion"), **shared)
    side = one_of(SIDES, given.side or "left", "--side")
    return partial(OneCameraGauge, side=side, plane_mm=given.plane_mm, **shared)
