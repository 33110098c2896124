"""What route V refuses when one view is not that of the same bar: its picture is moved, or drawn smaller."""

import cv2
import numpy as np
import pytest
from test_virtual_board_route import gauge_of

from appliance.simulation.bars.study_scenes import draw
from vision.reasons import Reason

SEED = 300


@pytest.fixture(scope="module")
def scene():
    return draw("clean", SEED)


def changed(picture, *, across_px=0.0, scale=1.0):
    rows, columns = picture.shape[:2]
    matrix = np.array([[scale, 0, across_px + (1 - scale) * columns / 2], [0, 1, 0.0]])
    return cv2.warpAffine(picture, matrix, (columns, rows), borderMode=cv2.BORDER_REPLICATE)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"across_px": 40}, Reason.IMPLAUSIBLE),  # the outlines meet far below or above the rollers
        ({"across_px": 120}, Reason.NOT_ALIGNED),  # they meet at no height at all
        ({"scale": 0.9}, Reason.VIEWS_DISAGREE),  # no round bar is that much narrower from one side
    ],
)
def test_a_view_that_does_not_fit_the_other_gives_no_value_and_a_reason(scene, change, reason):
    reading = gauge_of(scene).measure(scene.left, changed(scene.right, **change))
    assert not reading.valid
    assert np.isnan(reading.diameter_mm)
    assert reason in reading.reasons


def test_outlines_that_overlap_worse_than_a_round_bar_s_are_a_poor_alignment(scene):
    whole = gauge_of(scene).measure(scene.left, scene.right)
    narrow = gauge_of(scene).measure(scene.left, changed(scene.right, scale=0.9))
    assert Reason.POOR_ALIGNMENT in narrow.reasons
    assert Reason.POOR_ALIGNMENT not in whole.reasons
    assert abs(narrow.alignment_quality) < abs(whole.alignment_quality)


@pytest.mark.parametrize(("kept", "reason"), [(2, Reason.NO_WINDOWS), (8, Reason.FEW_WINDOWS), (15, Reason.NONE)])
def test_the_share_of_windows_that_agree_decides_whether_there_is_a_value(scene, kept, reason):
    reasons = gauge_of(scene)._reasons_of_windows(np.full(20, 200.0), np.arange(20) < kept)
    assert reasons == reason
