"""Why a calibration is refused, told by what is known of each picture and not by its name."""

import numpy as np
import pytest

from vision.calibration.acceptance import LEAST_PAIRS, CalibrationError, Dropped, check_pairs, some_names
from vision.calibration.initial_guess import View


def views(*boards):
    return [View(side, board, np.zeros((28, 2))) for board in boards for side in (0, 1)]


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
