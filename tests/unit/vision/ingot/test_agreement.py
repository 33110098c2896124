"""Which ingots are learned from: their own pictures agree with what was decided."""

from types import SimpleNamespace

import pytest

from vision.ingot.agreement import AGREED_FRAMES, Agreement


def confirmed(orientations, decided, confidence=99.9):
    agreement = Agreement()
    current = SimpleNamespace(ingot=1, orientation=decided, confidence=confidence)
    readings = [SimpleNamespace(present=True, orientation=one) for one in orientations]
    return [agreement.add(reading, current) for reading in readings]


@pytest.mark.parametrize("decided", ["top", "bottom"])
def test_an_ingot_whose_pictures_agree_is_confirmed_once(decided):
    said = confirmed([decided] * (AGREED_FRAMES + 5), decided)
    assert said == [None] * (AGREED_FRAMES - 1) + [decided] + [None] * 5


@pytest.mark.parametrize(("decided", "other"), [("top", "bottom"), ("bottom", "top")])
def test_an_ingot_of_which_a_tenth_of_the_pictures_say_the_other_end_is_not(decided, other):
    pictures = [other if number % 10 == 0 else decided for number in range(10 * AGREED_FRAMES)]
    assert set(confirmed(pictures, decided)) == {None}


def test_neither_doubt_nor_too_little_confidence_is_learned_from():
    assert set(confirmed(["top"] * 40, "undecided")) == {None}
    assert set(confirmed(["top"] * 40, "top", confidence=98.9)) == {None}
