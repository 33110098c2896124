"""The simulated mill as the experiments use it: one rig, calibrated by the product from its boards."""

import json
from functools import lru_cache

import numpy as np

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Picture, Scene
from appliance.simulation.boards.boards import Board as TrueBoard
from appliance.simulation.boards.boards import board_document, observe
from appliance.simulation.sensor import Sensor
from appliance.simulation.true_rig import TrueRig, default_rig
from vision.calibration.checkerboard import Board
from vision.calibration.rig import Rig
from vision.calibration.stereo import calibrate

ImageSize = tuple[int, int]  # columns, rows

SMALL: ImageSize = (800, 600)
FULL: ImageSize = (2704, 1520)  # of the dissertation's optical cameras, "2.7K"
SEED = 2500


@lru_cache(maxsize=2)
def calibrated(image_size: ImageSize) -> tuple[TrueRig, Rig]:
    """The rig as it is, and as the product calibrates it from corners with detector noise and a board with errors.

    Baseline 1.5 m at a distance of 3 m, boards at 0 and 200 mm.
    """
    true_rig = default_rig(image_size)
    rng = np.random.default_rng([SEED, *image_size])
    board = TrueBoard.with_errors(rng)
    seen = observe(true_rig, rng, board)
    known = Board.from_json(json.dumps(board_document(board, Sensor().response)))
    region_y_mm = true_rig.region_y_mm
    return true_rig, calibrate(seen.calibration, seen.low, seen.high, known, image_size, region_y_mm=region_y_mm).rig


@lru_cache(maxsize=1)
def _scene(image_size: ImageSize) -> Scene:
    return Scene(default_rig(image_size), SEED)


def pair(bar: Bar, frame: int, image_size: ImageSize) -> tuple[Picture, Picture]:
    """Left and right picture of a bar; the frame chooses the noise.

    Parameters
    ----------
    bar : Bar
    frame : int
    image_size : tuple of int
    """
    return _scene(image_size).pair(bar, frame)


def passing(diameter_mm: float, frame: int, **more: object) -> Bar:
    """A bar as it lies in a frame of a video: it moves a little to the side, turns and hops from frame to frame.

    Parameters
    ----------
    diameter_mm : float
    frame : int
    **more
        Of `Bar`.
    """
    rng = np.random.default_rng([SEED, frame, 0x7061])
    place = {
        "offset_mm": float(rng.uniform(-40, 40)),
        "yaw_deg": float(rng.uniform(-1.2, 1.2)),
        "lift_mm": float(abs(rng.normal(0, 0.5))),
        "warm_side_deg": float(rng.uniform(30, 150)),
    }
    return Bar(diameter_mm, **(place | more))  # pyright: ignore[reportArgumentType]  fields by name
