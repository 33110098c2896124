"""The moment of a stream's pictures, from arrivals that the tests make up."""

import pytest

from appliance.cameras.picture_clock import SETTLE_S, Arrival, CameraClock, PresentationClock, RhythmClock
from appliance.cameras.source import CameraError

PERIOD_S = 0.04
SETTLED = round(SETTLE_S / PERIOD_S) + 2


def arrival(arrived_s, presented_s=0.0, waited_s=0.02, camera_utc_s=None, arrived_utc_s=0.0):
    return Arrival(arrived_s, waited_s, presented_s, camera_utc_s, arrived_utc_s)


def moments_with_stall(clock):
    """True moment and told moment of pictures of which those from 4 s to 6 s are held back until 6 s."""
    told = []
    arrived_s = 0.0
    for number in range(250):
        exposed_s = number * PERIOD_S
        due_s = exposed_s if not 4 < exposed_s < 6 else 6.0
        waited_s = max(due_s - arrived_s, 0.0)
        arrived_s = max(due_s, arrived_s + 0.0005)
        told.append((exposed_s, clock.moment_s(arrival(arrived_s, 1000 + exposed_s, waited_s))))
    return told


@pytest.mark.parametrize("kind", [PresentationClock, RhythmClock])
def test_what_a_stall_held_back_is_never_younger_than_it_is(kind):
    told = [(exposed_s, moment_s) for exposed_s, moment_s in moments_with_stall(kind(0.0)) if moment_s is not None]
    assert all(moment_s <= exposed_s + 0.01 for exposed_s, moment_s in told)
    assert sum(exposed_s > 6.2 for exposed_s, _ in told) > 50  # and afterwards it goes on


def test_presentation_times_keep_held_back_pictures_with_their_age():
    told = moments_with_stall(PresentationClock(0.0))
    held = [moment_s for exposed_s, moment_s in told if 4.1 < exposed_s < 5.9]
    assert None not in held
    assert held == pytest.approx([exposed_s for exposed_s, _ in told if 4.1 < exposed_s < 5.9], abs=0.01)


def test_pictures_that_a_server_had_in_store_are_waited_out():
    clock = PresentationClock(0.0)
    told = [clock.moment_s(arrival(5 + 0.001 * number, number * PERIOD_S)) for number in range(50)]  # a GOP at once
    later = [clock.moment_s(arrival(5.05 + 49 * 0 + PERIOD_S * n, (50 + n) * PERIOD_S)) for n in range(SETTLED)]
    assert told == [None] * 50
    assert later[-1] == pytest.approx(5.05 + PERIOD_S * (SETTLED - 1))


def test_a_clock_that_drifts_is_followed():
    clock = PresentationClock(0.0)
    told = [(t, clock.moment_s(arrival(t, t * (1 - 50e-6)))) for t in (number * PERIOD_S for number in range(90_000))]
    exposed_s, moment_s = told[-1]
    assert moment_s == pytest.approx(exposed_s, abs=0.001)


@pytest.mark.parametrize(("step_s", "match"), [(-0.5, "back by 0.50 s"), (30.0, "ahead by 29.96 s")])
def test_presentation_times_that_jump_are_a_fault(step_s, match):
    clock = PresentationClock(0.0)
    for number in range(SETTLED):
        clock.moment_s(arrival(number * PERIOD_S, number * PERIOD_S))
    before_s = (SETTLED - 1) * PERIOD_S
    with pytest.raises(CameraError, match=match) as raised:
        clock.moment_s(arrival(before_s + PERIOD_S, before_s + step_s))
    assert raised.value.fault == "camera_clock_wrong"


def test_a_picture_that_was_there_before_it_was_asked_for_is_not_measured():
    clock = RhythmClock(0.0)
    for number in range(SETTLED):
        moment_s = clock.moment_s(arrival(number * PERIOD_S))
    assert moment_s is not None
    assert clock.moment_s(arrival(SETTLED * PERIOD_S, waited_s=0.0)) is None


def test_a_camera_that_changes_its_rate_is_followed():
    clock = RhythmClock(0.0)
    moments = [clock.moment_s(arrival(number * PERIOD_S)) for number in range(200)]
    slower = [clock.moment_s(arrival(8 + 3 * number * PERIOD_S)) for number in range(100)]
    assert None not in moments[SETTLED:]
    assert None not in slower[40:]


def test_the_cameras_own_clock_tells_the_moment():
    clock = CameraClock()
    assert clock.moment_s(arrival(100.0, camera_utc_s=999.75, arrived_utc_s=1000.0)) == pytest.approx(99.75)


def test_a_camera_that_sends_no_time_is_one_sentence():
    clock = CameraClock()
    assert clock.moment_s(arrival(0.0)) is None
    with pytest.raises(CameraError, match="set clock = 'arrival'"):
        clock.moment_s(arrival(16.0))
