"""Which pictures of a stream are whole: from a key picture on, until anything is damaged."""

from types import SimpleNamespace

import pytest

from appliance.cameras.stream.damage import WholePictures


def packet(pts, *, key=False, corrupt=False):
    return SimpleNamespace(pts=pts, is_keyframe=key, is_corrupt=corrupt)


def picture(pts, *, corrupt=False):
    return SimpleNamespace(pts=pts, is_corrupt=corrupt)


def followed(whole, one, *, frames=(), said=()):
    whole.follow(one, frames or [picture(one.pts)], said)
    return whole.holds(picture(one.pts))


def test_nothing_is_whole_before_a_key_picture_whose_time_is_known():
    whole = WholePictures()
    assert not followed(whole, packet(1))
    assert not followed(whole, packet(None, key=True))
    assert followed(whole, packet(3, key=True))
    assert followed(whole, packet(4))
    assert not whole.holds(picture(2)), "a picture from before the key picture"
    assert not whole.holds(picture(None))
    assert whole.damaged == 2


@pytest.mark.parametrize(
    "damage",
    [
        {"frames": [picture(4, corrupt=True)]},
        {"said": [(24, "h264", "concealing 120 DC errors")]},
        {"said": [(48, "h264", "Frame num gap 4 2")]},
    ],
)
def test_after_damage_nothing_is_whole_before_the_next_key_picture(damage):
    whole = WholePictures()
    assert followed(whole, packet(3, key=True))
    assert not followed(whole, packet(4), **damage)
    assert not followed(whole, packet(5))
    assert followed(whole, packet(6, key=True))
    assert whole.damaged == 2


def test_a_damaged_key_picture_begins_nothing():
    whole = WholePictures()
    assert not followed(whole, packet(3, key=True, corrupt=True))
    assert not followed(whole, packet(4))
