"""A case of the committed report, drawn anew every time, gives as printed what was committed."""

import json
import random
import shutil
from pathlib import Path

import pytest

from appliance.reproduction.run import experiments, reproduce
from studies.test_samples import alike

RESULTS = Path(__file__).parents[2] / "docs" / "reproduction" / "results"
EXPERIMENTS = {one.name: one for one in experiments(None)}


def printed(name, result):
    """What the dissertation's own ways gave: what is served has studies of its own, and times are the computer's."""
    if name == "thermal":
        return {number: result[number] for number in ("1", "2", "3", "4")}
    if name == "one_camera":
        return result["as printed"]
    if name == "boards":
        return {way: result["ways"][way] for way in ("as printed", "+ turned rows")}
    if name == "fusion":
        return result["metrics"]
    return [end[:3] for end in result["ends"]]


def stored(name):
    return [json.loads(line) for line in (RESULTS / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()]


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_the_committed_results_are_of_all_cases(name):
    assert [row["case"] for row in stored(name)] == EXPERIMENTS[name].cases(quick=False)


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_a_row_without_a_figure_says_why(name):
    rows = [(row["case"], row["result"]) for row in stored(name)]
    for table in EXPERIMENTS[name].section(rows).tables:
        missing = [row for row in table.rows if any(part == "-" for cell in row[1:] for part in cell.split(" / "))]
        assert table.note or not missing, table.title


def test_the_committed_report_says_what_the_committed_results_give(tmp_path):
    shutil.copytree(RESULTS, tmp_path / "results")
    reproduce(tmp_path)
    assert (tmp_path / "report.md").read_text("utf-8") == RESULTS.with_name("report.md").read_text("utf-8")


def test_a_case_gives_what_was_committed():
    name = random.choice([name for name in EXPERIMENTS if name != "registration"])  # RANSAC's draws are its library's
    row = random.choice(stored(name))
    again = json.loads(json.dumps(EXPERIMENTS[name].run(row["case"])))
    assert printed(name, again) == alike(printed(name, row["result"])), (name, row["case"])
