"""Why a calibration is refused, told by what is known of each picture and not by its name."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.simulation.true_rig import default_rig
from vision.calibration.acceptance import LEAST_PAIRS, CalibrationError, Dropped, check_pairs, limits, some_names
from vision.calibration.initial_guess import Pose, View


def views(*boards):
    return [View(side, board, np.zeros((28, 2))) for board in boards for side in (0, 1)]


JUDGED = {  # a value without a word, one that gives a warning, one that is refused
    "residual": (0.19, 0.3, 0.51),
    "tilts": (26.0, 24.0, 9.0),
    "apart": (0.16, 0.14, 0.04),
    "cover": (0.35, 0.2, 0.05),
    "focal length": (0.0049, 0.006, 0.021),
}


@pytest.mark.parametrize("what", JUDGED)
@pytest.mark.parametrize("verdict", [0, 1, 2])
def test_a_calibration_is_doubted_and_refused_from_the_stated_values_on(what, verdict):
    value = {name: values[verdict if name == what else 0] for name, values in JUDGED.items()}
    rig = perfect_rig(default_rig())
    relative = np.zeros((30, 30))
    relative[0, 0] = (value["focal length"] * rig.left.K[0, 0]) ** 2
    along = (rig.right.centre_mm - rig.left.centre_mm) / rig.baseline_mm
    aside = np.cross(along, [0.0, 0.0, 1.0])
    boards_mm = rig.left.centre_mm + rig.baseline_mm / value["apart"] * aside / np.linalg.norm(aside)
    boards = [Pose(cv2.Rodrigues(np.deg2rad([tilt, 0.0, 0.0]))[0], boards_mm) for tilt in (0.0, value["tilts"])]
    edge = np.linspace(0, np.sqrt(value["cover"]), 40)
    corners = np.stack(np.meshgrid(800 * edge, 600 * edge), axis=-1).reshape(-1, 2)
    views = [View(side, "00", corners) for side in (0, 1)]
    found = limits(replace(rig, covariance=relative, residual_px=value["residual"]), views, boards)
    told = [limit for limit in found if limit.close or limit.broken]
    assert [limit.broken for limit in told] == [[], [False], [True]][verdict] * (2 if what == "cover" else 1)
    assert all(what in limit.text for limit in told)


def test_boards_of_another_moment_are_counted_once_however_their_pictures_are_named():
    seen = views(*(f"{number:02d}" for number in range(LEAST_PAIRS - 1)))
    dropped = [Dropped(name, "they differ", "07", other_moment=True) for name in ("LEFT 7", "cam2-right-007")]
    with pytest.raises(CalibrationError, match=r"the others, 1, are not of one moment"):
        check_pairs(seen, dropped)


def test_a_low_board_that_is_not_found_is_named_whatever_its_picture_is_called():
    seen = views(*(f"{number:02d}" for number in range(LEAST_PAIRS)))
    with pytest.raises(CalibrationError, match="no picture of the low board is usable"):
        check_pairs(seen, [Dropped("Left_Low", "no board", "low")])
    check_pairs(seen, [Dropped("left_slow_7", "no board", "07")])


def test_of_many_names_the_first_ones_are_shown():
    assert some_names(["a", "b"]) == "a, b"
    assert some_names(list("abcdef")) == "a, b, c, d, 2 more"
