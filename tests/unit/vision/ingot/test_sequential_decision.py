"""One decision per ingot out of frames that may each be wrong, and when an ingot begins and ends."""

import math

import numpy as np
import pytest

from vision.ingot.sequential_decision import DecisionRule, IngotFollower
from vision.readings import OrientationReading
from vision.reasons import IngotReason

NOTHING = OrientationReading(reasons=IngotReason.NOTHING_HOT)
HANGING = OrientationReading(reasons=IngotReason.HANGING)


def seen(log_odds, y=240.0, x=480.0):
    return OrientationReading(
        present=True, log_odds=log_odds, center_x=x, center_y=y, radius=40.0, ssim_top=0.8, ssim_bottom=0.7
    )


def lying(log_odds, frames, start=240.0, step=2.0):
    return [seen(log_odds, start + step * frame) for frame in range(frames)]


def told(readings, rule=None, end=True):
    follower = IngotFollower(rule)
    decisions = [decision for frame, reading in enumerate(readings) for decision in follower.add(frame, reading)]
    return decisions + (follower.end() if end else [])


def test_clear_evidence_decides_as_soon_as_enough_pictures_count():
    (top,) = told([NOTHING, *lying(10.0, 20)])
    assert (top.ingot, top.orientation, top.first_frame, top.decided_frame) == (1, "top", 1, 4)
    assert top.confidence > 99.98
    assert (top.ssim_top, top.ssim_bottom) == pytest.approx((0.8, 0.7))
    (bottom,) = told(lying(-10.0, 20))
    assert (bottom.orientation, bottom.decided_frame) == ("bottom", 3)


def test_weak_evidence_waits_and_is_decided_late_or_never():
    (weak,) = told(lying(-2.0, 40))
    assert weak.orientation == "bottom"
    assert weak.decided_frame == DecisionRule().late_frames
    (none,) = told(lying(1.0, 40))
    assert (none.orientation, none.decided_frame) == ("undecided", None)
    assert 50 < none.confidence < 90


def test_a_top_needs_more_evidence_than_a_bottom():
    (top,), (bottom,) = told(lying(6.5, 14)), told(lying(-6.5, 14))
    assert (top.orientation, bottom.orientation) == ("undecided", "bottom")


def test_pictures_of_one_ingot_never_count_as_more_than_the_correlation_allows():
    """However many say 3, together they say less than 3 / rho: no alarm at the strict bound of 9.2."""
    rule = DecisionRule(late_frames=10_000)
    (ingot,) = told(lying(3.0, 500, step=0.1), rule)
    assert ingot.orientation == "undecided"
    assert ingot.confidence == pytest.approx(100 / (1 + math.exp(-3.0 / rule.correlation)), abs=0.05)


def test_one_extreme_picture_does_not_outvote_all_others_of_its_ingot():
    (ingot,) = told([*lying(-8.0, 2), seen(1e6, 244), *lying(-8.0, 20, start=246)])
    assert ingot.orientation == "bottom"


def test_an_ingot_that_moves_as_only_the_crane_moves_it_is_none():
    lowered = [seen(20.0, 150.0 + 25 * frame) for frame in range(8)]
    lifted = [seen(20.0, 350.0 - 6 * frame) for frame in range(8)]
    assert told(lowered + lifted) == []


def test_what_was_read_of_a_hanging_ingot_is_void():
    """It hangs almost still, is seen now and then, and is set down the other way round."""
    hung, ingot = told([*lying(5.0, 6, step=0.5), HANGING, *lying(-10.0, 10, start=245)])
    assert (hung.orientation, ingot.orientation) == ("undecided", "bottom")
    assert told([reading for _ in range(10) for reading in (*lying(20.0, 3, step=0.2), HANGING)]) == []


def test_the_next_ingot_is_a_new_one():
    sequence = [*lying(10.0, 20), *[NOTHING] * 6, *lying(-10.0, 20)]
    assert [(one.ingot, one.orientation) for one in told(sequence)] == [(1, "top"), (2, "bottom")]
    at_once = [*lying(10.0, 40), *lying(-10.0, 20)]  # set down behind one that was not seen leaving
    assert [(one.ingot, one.orientation) for one in told(at_once)] == [(1, "top"), (2, "bottom")]


def test_a_few_missed_pictures_do_not_part_an_ingot():
    (ingot,) = told([*lying(3.0, 3), *[NOTHING] * 4, *lying(10.0, 10, start=250)])
    assert ingot.first_frame == 0


def test_an_ingot_is_told_once_and_stays_as_decided():
    follower = IngotFollower()
    for frame, reading in enumerate(lying(10.0, 6)):
        follower.add(frame, reading)
    assert follower.current.orientation == "top"
    later = [
        one for frame, reading in enumerate(lying(-10.0, 30, start=254)) for one in follower.add(6 + frame, reading)
    ]
    assert later == []
    assert follower.current.orientation == "top"
    for frame in range(5):
        follower.add(40 + frame, NOTHING)
    assert follower.current is None


def test_stated_error_rates_hold_for_evidence_that_is_what_it_says():
    """Ingots whose common log odds are normal as odds demand (mean half the variance), and pictures that scatter."""
    rng = np.random.default_rng(1)
    rule = DecisionRule(false_alarm=0.01, missed=0.01, late_false_alarm=0.05, late_missed=0.05, evidence_limit=50)
    wrong = decided = 0
    for number in range(2000):
        is_top = number % 2 == 0
        common = rng.normal(8.0 if is_top else -8.0, 4.0)
        readings = [seen(common + rng.normal(0, 1), 240 + 2 * frame) for frame in range(20)]
        (ingot,) = told(readings, rule)
        decided += ingot.orientation != "undecided"
        wrong += ingot.orientation == ("bottom" if is_top else "top")
    assert decided > 1800
    assert wrong / 2000 < 0.05


def test_wrong_calls_name_the_argument():
    with pytest.raises(ValueError, match="missed"):
        DecisionRule(missed=0.5)
    with pytest.raises(ValueError, match="correlation"):
        DecisionRule(correlation=1.0)


def test_an_ingot_that_is_followed_across_a_missed_picture_may_have_moved_twice_as_far():
    rule = DecisionRule()
    step = 0.9 * rule.still * 40.0
    readings = [seen(0.0, 240.0 + step * place) for place in range(12)]
    for place in (5, 8):
        readings[place] = NOTHING
    follower = IngotFollower(rule)
    for frame, reading in enumerate(readings):
        follower.add(frame, reading)
    assert follower._now.frames == 9, "ten pictures show it, and only the first does not count"


def test_an_end_that_was_seen_larger_is_still_the_same_ingot():
    small, large = (
        seen(1.0),
        OrientationReading(present=True, log_odds=1.0, center_x=535.0, center_y=240.0, radius=60.0),
    )
    for first, second in ((small, large), (large, small)):
        follower = IngotFollower()
        follower.add(0, first)
        begun = follower._now
        follower.add(1, second)
        assert follower._now is begun
    aside = OrientationReading(present=True, log_odds=1.0, center_x=545.0, center_y=240.0, radius=60.0)
    follower = IngotFollower()
    follower.add(0, small)
    begun = follower._now
    follower.add(1, aside)
    assert follower._now is not begun
