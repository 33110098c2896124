"""Pairs of two cameras against what a shutter that fires both at once must give."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from appliance.cameras.pairing import Exposure, Pairing
from vision.sent_picture import SentPicture

PERIOD_S = 0.1


def exposure(number, *, shift_s=0.0, first=0):
    moment_s = number * PERIOD_S + shift_s
    return Exposure(
        SentPicture.of(np.full((1, 1), number, np.uint8)), first + number, round(moment_s * 1e6), moment_s, 500.0
    )


@given(st.permutations([0] * 6 + [1] * 6), st.integers(-50, 50))
def test_however_late_a_camera_is_only_pictures_of_one_exposure_are_paired(sides, first):
    pairing = Pairing(0.001, same_sequence=False)
    numbers = (itertools.count(), itertools.count())
    pairs = []
    for side in sides:
        pairing.add(side, exposure(next(numbers[side]), first=first * side))
        if pair := pairing.newest_pair():
            pairs.append(pair)
    assert all(pair.left[0, 0] == pair.right[0, 0] for pair in pairs)
    assert [pair.sequence for pair in pairs] == sorted({pair.sequence for pair in pairs})
    assert pairs
    assert pairs[-1].dropped == pairs[-1].sequence + 1 - len(pairs)


def test_only_the_newest_of_several_complete_pairs_is_delivered():
    pairing = Pairing(0.001, same_sequence=True)
    for number in range(4):
        pairing.add(0, exposure(number))
        pairing.add(1, exposure(number))
    assert pairing.newest_pair().left[0, 0] == 3
    assert pairing.newest_pair() is None


def test_sensors_of_one_device_must_agree_on_the_number():
    pairing = Pairing(0.001, same_sequence=True)
    pairing.add(0, exposure(1))
    pairing.add(1, exposure(1, first=1))
    assert pairing.newest_pair() is None


def test_pictures_that_are_too_far_apart_wait_until_no_nearer_partner_can_come():
    pairing = Pairing(0.001, same_sequence=False)
    pairing.add(0, exposure(5))
    assert pairing.behind == 1
    pairing.add(1, exposure(5, shift_s=-0.03))
    assert pairing.newest_pair() is None
    pairing.add(1, exposure(6, shift_s=-0.03))
    pair = pairing.newest_pair()
    assert (pair.left[0, 0], pair.right[0, 0]) == (5, 5)
    assert pair.left_us - pair.right_us == 30_000


def test_a_right_picture_waits_for_the_left_one_that_was_exposed_just_after_it():
    pairing = Pairing(0.01, same_sequence=False)
    pairing.add(0, exposure(5))
    pairing.add(1, exposure(6, shift_s=-0.02))
    assert pairing.newest_pair() is None
    pairing.add(0, exposure(6))
    pairing.add(1, exposure(7, shift_s=-0.02))
    pair = pairing.newest_pair()
    assert (pair.left[0, 0], pair.left_us - pair.right_us) == (6, 20_000)


def test_a_camera_that_waits_for_ever_keeps_only_a_few_pictures():
    pairing = Pairing(0.001, same_sequence=False)
    for number in range(200):
        pairing.add(0, exposure(number))
    pairing.add(1, exposure(3))
    assert pairing.newest_pair() is None
    pairing.add(1, exposure(199))
    assert pairing.newest_pair().sequence == 0
