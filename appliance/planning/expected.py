"""What the gauge would state for a planned mounting, from its own budget on the simulated mill.

The mounting is drawn as a simulated rig, calibrated from boards as a user would, and bars are measured in its pictures;
so the expected uncertainty is the one that the gauge itself would serve there.
"""

import json
import math
import statistics
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from appliance.errors import HotgaugeError
from appliance.planning.mounting import AIM_HEIGHT_MM, Mounting
from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.boards.boards import Board as TrueBoard
from appliance.simulation.boards.boards import BoardCorners, board_document, observe
from appliance.simulation.sensor import Sensor
from appliance.simulation.true_rig import TrueCamera, TrueRig, look_at
from appliance.sizing.stereo.gauge import TimedGauge, pair_gauge
from vision.calibration.acceptance import CalibrationError
from vision.calibration.checkerboard import Board
from vision.calibration.stereo import calibrate
from vision.readings import SizeReading

FRAMES = 3  # chosen, of each bar
SEED = 1
PARTS = ("edge", "calibration", "board", "light", "shape", "model")


class PlanError(HotgaugeError):
    """A mounting cannot work; the message says why and what to change."""


class Expected(NamedTuple):
    """What the gauge would state of one bar.

    Attributes
    ----------
    diameter_mm : float
        Of the simulated bar.
    expanded_mm : float
        Median U (k = 2); NaN where it gives no value.
    error_mm : float
        Mean error of the readings, for comparison.
    parts_mm : dict of str to float
        Standard uncertainties (k = 1) of the parts of the budget, medians.
    reasons : list of str
        Why there is no value, or why to doubt it.
    """

    diameter_mm: float
    expanded_mm: float
    error_mm: float
    parts_mm: dict[str, float]
    reasons: list[str]


def expected(
    mounting: Mounting,
    diameters_mm: Sequence[float],
    region_y_mm: tuple[float, float],
    ovality_mm: float | None,
    progress: Callable[[int, int], None],
) -> list[Expected]:
    """Measure simulated bars with the mounting.

    Parameters
    ----------
    mounting : Mounting
    diameters_mm : sequence of float
    region_y_mm : tuple of float
        Measuring region along the line.
    ovality_mm : float or None
        Greatest minus least width that the product may have; None: as `Gauge` assumes it.
    progress : callable
        Gets bars done and of all.

    Raises
    ------
    PlanError
        The pictures do not hold the measuring region, or no calibration is possible.
    """
    rig = true_rig(mounting, region_y_mm)
    check_view(rig, max(diameters_mm))
    gauge = _gauge(rig, ovality_mm)
    scene = Scene(rig, SEED)
    found: list[Expected] = []
    for done, diameter_mm in enumerate(diameters_mm):
        progress(done, len(diameters_mm))
        pairs = (scene.pair(Bar(diameter_mm, yaw_deg=0.5), frame) for frame in range(FRAMES))
        found.append(_summary(diameter_mm, [gauge.measure(*pair)[0] for pair in pairs]))
    progress(len(diameters_mm), len(diameters_mm))
    return found


def true_rig(mounting: Mounting, region_y_mm: tuple[float, float]) -> TrueRig:
    """The mounting as a rig of the simulated mill, with perfect lenses.

    Parameters
    ----------
    mounting : Mounting
    region_y_mm : tuple of float
    """
    aim_mm = np.array([0.0, 0.0, AIM_HEIGHT_MM])
    focal, middle = mounting.focal_px, (mounting.columns / 2 - 0.5, mounting.rows / 2 - 0.5)
    K = np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1.0]])
    size = mounting.columns, mounting.rows
    cameras = [
        TrueCamera(K, np.zeros(5), *look_at(np.array(place_mm), aim_mm, 0.0), size) for place_mm in mounting.cameras_mm
    ]
    return TrueRig(cameras[0], cameras[1], region_y_mm)


def check_view(rig: TrueRig, largest_mm: float) -> None:
    """Raise `PlanError` unless both pictures hold the measuring region with the largest bar in it.

    Parameters
    ----------
    rig : TrueRig
    largest_mm : float
    """
    half_mm = 0.75 * largest_mm + 50
    corners = [(x, y, z) for x in (-half_mm, half_mm) for y in rig.region_y_mm for z in (0.0, largest_mm)]
    if not all(camera.sees(np.array(corners), 10.0) for camera in rig.cameras):
        raise PlanError(
            f"the pictures do not hold the region of {rig.region_y_mm[1] - rig.region_y_mm[0]:g} mm with a bar of "
            f"{largest_mm:g} mm; take a shorter focal length, more distance, or a smaller --region"
        )


def _gauge(rig: TrueRig, ovality_mm: float | None) -> TimedGauge[SizeReading]:
    rng = np.random.default_rng(SEED)
    true_board = TrueBoard.with_errors(rng)
    board = Board.from_json(json.dumps(board_document(true_board, Sensor().response)))
    try:
        seen: BoardCorners = observe(rig, rng, true_board)
        found = calibrate(
            seen.calibration, seen.low, seen.high, board, rig.left.image_size, region_y_mm=rig.region_y_mm
        )
    except (ValueError, CalibrationError) as error:
        raise PlanError(
            f"no board of 8 x 5 squares of 50 mm calibrates this mounting ({error}); give another lens or distance"
        ) from error
    return pair_gauge(found.rig, "planned rig", ovality_mm)


def _summary(diameter_mm: float, readings: Sequence[SizeReading]) -> Expected:
    valid = [reading for reading in readings if reading.valid]
    reasons = sorted({name for reading in readings for name in reading.reasons.names})
    if not valid:
        return Expected(diameter_mm, math.nan, math.nan, dict.fromkeys(PARTS, math.nan), reasons)
    return Expected(
        diameter_mm,
        statistics.median(reading.expanded_uncertainty_mm for reading in valid),
        statistics.fmean(reading.diameter_mm for reading in valid) - diameter_mm,
        {part: statistics.median(getattr(reading, f"u_{part}_mm") for reading in valid) for part in PARTS},
        reasons,
    )
