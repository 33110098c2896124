"""Figures that documents state are those of the studies' results."""

import json
import re
import runpy
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
STUDIES = REPOSITORY / "docs" / "studies"
WRITER = runpy.run_path(str(STUDIES / "__main__.py"))
TEXTS = WRITER["texts"]()
MARKED = [
    (path, name) for path in TEXTS for name in re.findall(r"^<!-- table: (.+) -->$", path.read_text(), re.MULTILINE)
]


def result(name):
    return json.loads((STUDIES / f"{name}.json").read_text(encoding="utf-8"))


def summary(name):
    return result(name)["summary"]


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.name)
def test_a_table_of_a_study_is_the_one_of_its_results(path):
    assert path.read_text(encoding="utf-8") == TEXTS[path], "run `make tables`"


def test_every_table_that_can_be_written_stands_in_one_document():
    assert sorted(name for _, name in MARKED) == sorted(WRITER["TABLES"])


def test_a_changed_figure_is_written_anew():
    path, name = MARKED[0]
    text = TEXTS[path]
    row = text.split(f"<!-- table: {name} -->\n")[1].splitlines()[2]
    assert WRITER["with_tables"](text.replace(row, re.sub(r"\d", "7", row))) == text


def served():
    bars = summary("served_diameter")["bars"]
    seeds = {row["seed"] for row in result("served_diameter")["rows"]}
    return (
        f"Over {len(seeds)} rigs of the simulated mill, the ovality told as 0: RMSE {bars['rmse_mm']:.3f} mm, "
        f"{100 * bars['covered']:.1f} ± {100 * bars['covered_standard_error']:.1f} % of the values inside U"
    )


def line_with_everything():
    found = summary("real_line")
    every, told, untold = (found[name] for name in ("all", "ovality told", "ovality not told"))
    assert every["wrong_values"] == 0
    return (
        f"{every['lines']} lines) {100 * every['inside']:.0f} % of {every['frames']} frames lie inside U, median U "
        f"{told['median_expanded_mm']:.2f} mm where the ovality is told and {untold['median_expanded_mm']:.2f} mm where"
    )


def repeatability():
    found = summary("gauge_repeatability")["shimmer"]
    assert found["bars"] == 6
    return f"bar's value from eight frames are {found['bar_of_tolerance_percent']:.1f} % of a tolerance 4 mm wide (six"


def ingots():
    first, second = (summary("ingots_elsewhere")[name]["relief"] for name in ("ingot_line", "ingot_line_b"))
    ingots, right, undecided = (first[name] + second[name] for name in ("ingots", "right", "undecided"))
    assert right + undecided == ingots
    return (
        f"{100 * first['frames_right']:.0f} % of the frames of one line and {100 * second['frames_right']:.1f} % of "
        f"the other were right; of {ingots} ingots {right} were right, {undecided} stayed undecided, none was wrong"
    )


def routes():
    bars = summary("served_diameter")["bars"]
    sure = [row for row in result("served_diameter")["rows"] if row["condition"] in WRITER["BARS"] and row["valid"]]
    worst_mm = max(abs(row["error_mm"]) for row in sure if "few_windows" not in row["reasons"])
    return (
        f"`calibration_due` came with {100 * bars['calibration_due']:.1f} % of these values, `routes_disagree` with "
        f"{100 * bars['routes_disagree']:.1f} %. The largest error without `few_windows` is {worst_mm:.2f} mm."
    )


def worth():
    found = summary("worth")
    one, four = (found[name]["scale"]["rmse_mm"] for name in ("as served", "four planes"))
    with_marks, without = (found[name]["nudged"]["rmse_mm"] for name in ("as served", "without still marks"))
    wrong = {name: sum(one["wrong_values"] for one in found[name].values()) for name in found}
    kept = wrong["without any of these checks"] - wrong["as served"]
    return (
        f"One cylinder takes {one:.3f} mm where four planes take {four:.3f} on limbs that scale covers",
        f"take a nudge from {without:.3f} to {with_marks:.3f} mm",
        f"Together they keep {kept} of these frames from a wrong value",
    )


def nudged():
    large, small = (summary("nudged_camera")[degrees] for degrees in ("0.05", "0.02"))
    return (
        f"turned by 0.05 degrees the error is at most {large['worst_mm']:.2f} mm ({large['uncorrected_worst_mm']:.2f} "
        f"uncorrected), by 0.02 degrees {small['worst_mm']:.2f} mm ({small['uncorrected_worst_mm']:.2f}). Told by "
        f"`calibration_due`: {large['told']} and {small['told']} of {large['cameras']}"
    )


def compression():
    fitted = [summary("compression")[name]["fitted"] for name in ("jpeg", "h264")]
    off = [summary("compression")[name]["off"] for name in ("jpeg", "h264")]
    return (
        "the study fits " + " and ".join(", ".join(f"{one:.2f}" for one in law) for law in fitted),
        f"about the constants below by {100 * off[0]:.0f} and {100 * off[1]:.0f} %",
    )


STATED = (
    ("README.md", served),
    ("README.md", line_with_everything),
    ("README.md", repeatability),
    ("README.md", ingots),
    ("docs/methods/diameter.md", routes),
    ("docs/methods/diameter.md", worth),
    ("docs/methods/real_line.md", nudged),
    ("vision/compression.py", compression),
)


@pytest.mark.parametrize(("name", "figures"), STATED, ids=lambda one: getattr(one, "__name__", one))
def test_a_sentence_states_the_figures_of_its_study(name, figures):
    text = " ".join((REPOSITORY / name).read_text(encoding="utf-8").split())
    sentences = figures()
    for sentence in [sentences] if isinstance(sentences, str) else sentences:
        assert sentence in text
