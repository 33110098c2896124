"""Rigs of drawn scenes as the product calibrates them: corners with detector noise, boards with print errors."""

import json
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.boards.board_pictures import board_light
from appliance.simulation.boards.boards import Board as TrueBoard
from appliance.simulation.boards.boards import board_document, high_pose, low_pose, observe
from appliance.simulation.response import encode
from appliance.simulation.sensor import NoiseStock, Sensor
from vision.calibration.checkerboard import Board
from vision.calibration.stereo import calibrate
from vision.calibration.still_marks import find_marks
from vision.light import U_NAMED_EXPONENT


@lru_cache(maxsize=2)
def calibrated_rig(seed, image_size=(800, 600)):
    """The rig of a seed's scenes, calibrated from projected corners; without still marks, which need pictures."""
    return _calibrated(seed, image_size)[0]


@lru_cache(maxsize=2)
def rig_with_marks(seed):
    """The same rig with the still marks that both registration pictures show."""
    rig, board, seen, rng = _calibrated(seed)
    scene = set_up("clean", seed).scene_as_calibrated()
    lights = [(view, board_light(view, board, pose(board))) for view in (scene.left, scene.right) for pose in POSES]
    starts = rng.integers(NoiseStock.EXTRA, size=len(lights))
    pictures = [view.grey_picture(light, int(start)) for (view, light), start in zip(lights, starts, strict=True)]
    corners = list(zip(seen.low, seen.high, strict=True))
    return replace(rig, marks=(find_marks(*pictures[:2], corners[0]), find_marks(*pictures[2:], corners[1])))


POSES = (low_pose, high_pose)


def _calibrated(seed, image_size=(800, 600)):
    setup, (rng, true_board) = set_up("clean", seed, image_size), board_of(seed)
    seen = observe(setup.rig, rng, true_board)
    board = Board.from_json(json.dumps(board_document(true_board, setup.sensor.response)))
    size, region_y_mm = setup.rig.left.image_size, setup.rig.region_y_mm
    rig = calibrate(seen.calibration, seen.low, seen.high, board, size, region_y_mm=region_y_mm).rig
    return rig, true_board, seen, rng


def board_of(seed):
    """The board that calibrates a seed's rig, and the random numbers that its poses are drawn from next."""
    rng = np.random.default_rng([seed, 0x626F])
    return rng, TrueBoard.with_errors(rng)


def off_response(picture, seed):
    """The picture of a camera whose code values follow light with an exponent that is a little off.

    It is rounded to 8 bits a second time, so each code is off by a whole number of codes; `off_line` rounds once.
    """
    return np.rint(255 * (np.arange(256) / 255) ** _off_exponent(seed)).astype(np.uint8)[picture]


def off_line(line, seed):
    """The line as cameras show it whose response is off by the same exponent, rounded to code values once.

    Parameters
    ----------
    line : Line
    seed : int
    """
    right = line.setup.sensor
    off = _OffSensor(
        right.response, right.full_well_electrons, right.read_noise_electrons, exponent=_off_exponent(seed)
    )
    return replace(line, setup=replace(line.setup, sensor=off))


@dataclass(frozen=True, slots=True)
class _OffSensor(Sensor):
    """A sensor of 8 bits whose code values are those of its response to the power `exponent`."""

    exponent: float = 1.0

    def table(self):
        light = np.linspace(0.0, 1.0, self.levels + 1)
        return np.rint(255 * encode(light, self.response) ** self.exponent).astype(np.uint8)


def _off_exponent(seed):
    return np.random.default_rng([seed, 0x7265]).normal(1, U_NAMED_EXPONENT)
