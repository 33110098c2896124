"""A case of the committed report, drawn anew every time, gives the results that were committed; times excepted."""

import json
import random
from pathlib import Path

import pytest
from test_samples import alike

from appliance.reproduction.run import experiments

RESULTS = Path(__file__).parents[2] / "docs" / "reproduction" / "results"
TIMES = {"time_ms"}
EXPERIMENTS = {one.name: one for one in experiments(None)}


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(one) for key, one in value.items() if key not in TIMES}
    return [without_times(one) for one in value] if isinstance(value, list) else value


def stored(name):
    return [json.loads(line) for line in (RESULTS / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()]


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_the_committed_results_are_of_all_quick_cases(name):
    assert [row["case"] for row in stored(name)] == EXPERIMENTS[name].cases(quick=True)


def test_a_case_gives_what_was_committed():
    name = random.choice([name for name in EXPERIMENTS if name != "registration"])  # RANSAC's draws are its library's
    row = random.choice(stored(name))
    again = without_times(json.loads(json.dumps(EXPERIMENTS[name].run(row["case"]))))
    assert again == alike(without_times(row["result"])), (name, row["case"])
