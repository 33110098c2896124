"""Learned references on the disk: the commissioned pair stays, every pair can be used again."""

import json

import cv2
import numpy as np
import pytest

from appliance.ingot.learned_references import Learned, LearnedReferencesError, current_number, history, keep, pair, use
from appliance.ingot.reader_setup import ReferencesError, load_view

LEARNED = Learned(kind="top", confirmed_by="agreement", frame=7, utc_ms=1, before=0)


def plain(value):
    return np.full((64, 64), value, np.uint8)


@pytest.fixture
def references(tmp_path):
    for name, value in (("top", 10), ("bottom", 20)):
        cv2.imwrite(str(tmp_path / f"{name}.png"), plain(value))
    return tmp_path


def levels(references):
    view = load_view(references)
    return int(view.references.top.flat[0]), int(view.references.bottom.flat[0])


def test_the_newest_pair_is_used_and_any_pair_can_be_used_again(references):
    assert (current_number(references), levels(references)) == (0, (10, 20))
    assert keep(references, (plain(11), plain(20)), LEARNED) == 1
    assert keep(references, (plain(11), plain(22)), LEARNED) == 2
    assert levels(references) == (11, 22)
    use(references, 1)
    assert levels(references) == (11, 20)
    use(references, 0)
    assert levels(references) == (10, 20)
    assert history(references) == [1, 2]
    assert json.loads((references / "learned" / "000001" / "learned.json").read_text())["confirmed_by"] == "agreement"


def test_a_pair_after_a_way_back_does_not_overwrite_the_history(references):
    keep(references, (plain(11), plain(20)), LEARNED)
    use(references, 0)
    assert keep(references, (plain(12), plain(20)), LEARNED) == 2
    assert int(pair(references, 1)[0].flat[0]) == 11


def test_a_pair_that_is_not_there_is_refused_in_a_sentence_with_those_that_are(references):
    keep(references, (plain(11), plain(20)), LEARNED)
    with pytest.raises(LearnedReferencesError, match="there is no pair 5; learned are 1, 0 is the commissioned one"):
        use(references, 5)
    assert current_number(references) == 1


@pytest.mark.parametrize("text", ["", "[]", '{"number": "one"}', '{"number": 3}'])
def test_a_damaged_history_is_told_and_not_guessed(references, text):
    (references / "learned").mkdir()
    (references / "learned" / "current.json").write_text(text)
    with pytest.raises(ReferencesError):
        load_view(references)
