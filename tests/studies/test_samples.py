"""A sample of each study, drawn anew every time, gives what is written in docs/studies."""

import json
import random

import pytest

from studies.__main__ import NAMES, RESULTS, row, study

SAMPLE = 2  # unless the study says otherwise, because its cases take long
REPEATABLE = [name for name in NAMES if getattr(study(name), "REPEATABLE", True)]


def written_results(name):
    return json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", NAMES)
def test_written_results_are_of_all_cases_and_their_summary_is_of_them(name):
    written = written_results(name)
    assert written["cases"] == len(written["rows"]) == len(study(name).cases())
    assert study(name).summary(written["rows"]) == written["summary"]


@pytest.mark.parametrize("name", REPEATABLE)
def test_a_sample_of_a_study_agrees_with_its_written_results(name):
    written = written_results(name)
    for stored in random.sample(written["rows"], getattr(study(name), "SAMPLE", SAMPLE)):
        case = {key: stored[key] for key in study(name).cases()[0]}
        again = row(name, case)
        assert again.keys() == stored.keys(), case
        for key, value in stored.items():
            assert again[key] == alike(value), (case, key)


def alike(value):
    """What a value may be when another computer rounds differently, in lists and tables too."""
    if isinstance(value, float):
        return pytest.approx(value, rel=1e-3, abs=1e-3)
    if isinstance(value, list):
        return [alike(one) for one in value]
    return {key: alike(one) for key, one in value.items()} if isinstance(value, dict) else value
