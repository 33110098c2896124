"""Hundreds of spoilt files and command lines: done with a right result, or refused in one sentence."""

import itertools

import pytest

from studies.spoilt_inputs import COUNTS, run

FEW = {
    "board": 6,
    "rig": 20,
    "png": 12,
    "jpeg": 15,
    "video": 12,
    "stamps": 12,
    "coding": 12,
    "reference": 10,
    "roi": 15,
    "end picture": 8,
    "readings": 12,
    "truth": 12,
    "history": 12,
    "more words": 12,
}
MANY = 25  # of each kind that takes milliseconds
FIRST = 100_000  # other cases than the study's


@pytest.mark.parametrize("kind", COUNTS)
def test_whatever_is_handed_over_is_done_rightly_or_refused_in_a_sentence(kind):
    seeds = itertools.islice(itertools.count(FIRST), FEW.get(kind, MANY))
    outcomes = {seed: run({"kind": kind, "seed": seed})["outcome"] for seed in seeds}
    assert not {seed: said for seed, said in outcomes.items() if said not in {"done", "refused", "not run"}}
    assert "refused" in outcomes.values()
