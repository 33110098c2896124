"""`reproduce`: results are kept as they come, an interruption loses none, and the report holds what was found."""

import json
from collections import Counter

import numpy as np
import pytest
from counted_experiment import CountedExperiment

from appliance.cli.main import main
from appliance.reproduction import run
from appliance.reproduction.experiment import number
from appliance.reproduction.false_edges import _counted
from appliance.reproduction.ingots import PRINTED_SIMILARITY, IngotEnds, _verdict
from appliance.reproduction.registration import _error_px
from appliance.reproduction.run import ReproductionError, experiments, reproduce
from appliance.reproduction.sampling import mean_with_error, rms_with_error, share, verdict
from appliance.reproduction.thermal import DIAMETER_MM, Thermal


@pytest.fixture
def log(tmp_path, monkeypatch):
    log = tmp_path / "log"
    log.touch()
    monkeypatch.setattr(run, "experiments", lambda _: (CountedExperiment(log),))
    return log


def test_every_case_runs_once_and_the_report_tells_them_all(tmp_path, log):
    seen = []
    page = reproduce(tmp_path / "out", on_progress=lambda *steps: seen.append(steps))
    assert sorted(log.read_text().split()) == ["0", "1", "2", "3"]
    assert seen[0] == (0, 4)
    assert seen[-1] == (4, 4)
    text, html = (tmp_path / "out" / "report.md").read_text(), page.read_text()
    assert "| 3 | 9 |" in text
    assert "<td>3</td><td>9</td>" in html
    assert "Squares &lt;of numbers&gt;" in html
    assert (tmp_path / "out" / "figures" / "squares.png").stat().st_size > 3000


def test_after_an_interruption_only_what_is_missing_runs(tmp_path, log):
    results = tmp_path / "out" / "results"
    results.mkdir(parents=True)
    (results / "plan.json").write_text(json.dumps({"quick": False, "recordings": ""}))
    done = [{"case": {"value": value}, "result": {"square": value**2}} for value in (0, 2)]
    (results / "squares.jsonl").write_text("".join(json.dumps(row) + "\n" for row in done) + '{"case": {"val')
    reproduce(tmp_path / "out")
    assert sorted(log.read_text().split()) == ["1", "3"]
    reproduce(tmp_path / "out")
    assert sorted(log.read_text().split()) == ["1", "3"]


def test_results_of_another_plan_are_not_mixed(tmp_path, log, capsys):
    reproduce(tmp_path / "out", quick=True)
    assert log.read_text().split() == ["0", "1"] or sorted(log.read_text().split()) == ["0", "1"]
    with pytest.raises(ReproductionError, match="give a new folder"):
        reproduce(tmp_path / "out")
    (tmp_path / "file").touch()
    assert main(["reproduce", "--output", str(tmp_path / "file" / "out")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("experiment", experiments(None), ids=lambda one: one.name)
@pytest.mark.parametrize("quick", [True, False])
def test_cases_can_be_written_and_differ(experiment, quick):
    keys = [json.dumps(case, sort_keys=True) for case in experiment.cases(quick=quick)]
    assert len(keys) == len(set(keys)) >= 2
    assert [json.loads(key) for key in keys] == experiment.cases(quick=quick)


@pytest.mark.parametrize(("quick", "videos"), [(True, [2, 2]), (False, [4, 12])])
def test_half_of_the_videos_of_ingots_show_tops(quick, videos):
    """4 and 12 videos, section 6.5; quick: one of each kind."""
    cases = IngotEnds().cases(quick=quick)
    for part, count in enumerate(videos):
        labels = [case["label"] for case in cases if case["set"] == part]
        assert Counter(labels) == {"top": count / 2, "bottom": count / 2}


def test_recorded_ingots_join_where_recordings_are_given(recordings):
    ingots = experiments(recordings)[-1]
    assert {case["set"] for case in ingots.cases(quick=True)} == {0, 1, "ingot_line", "ingot_line_b"}


def test_the_thermal_table_stands_beside_the_published_one():
    experiment = Thermal()
    case = experiment.cases(quick=True)[0]
    result = json.loads(json.dumps(experiment.run(case)))
    assert len(result["served"]) == 10
    table = experiment.section([(case, result)]).tables[0]
    assert [row[1] for row in table.rows] == ["1.11", "1.03", "2.09", "0.87", "-"]  # table 3.1 of the dissertation
    assert all(abs(float(row[5].split(" ")[0])) < 8 for row in table.rows)


def test_printed_similarities_and_the_thermal_bar_are_those_of_the_dissertation():
    assert DIAMETER_MM == 165  # mm, section 3.4
    table_6_1 = """
        bottom-1 0.6905 0.3667 0.5562
        bottom-2 0.5934 0.4036 0.4976
        top-1 0.7985 0.5517 0.7139
        top-2 0.9021 0.6802 0.7901
    """
    rows = [line.split() for line in table_6_1.split("\n") if line.strip()]
    assert {name: tuple(map(float, values)) for name, *values in rows} == PRINTED_SIMILARITY


@pytest.mark.parametrize(("similar", "label"), [((0.9, 0.2), "top"), ((0.2, 0.9), "bottom")])
def test_each_classifier_judges_an_end_by_its_own_figures(similar, label):
    end = ["top", *similar, "unknown"]
    assert [_verdict(end, name) for name in ("single", "dual", "relief")] == [label, label, "unknown"]


def test_sampling_errors_are_those_of_the_textbooks():
    values = [1.0, 2.0, 3.0, 6.0, None, float("nan")]
    error = np.std(values[:4], ddof=1) / 2
    assert mean_with_error(values) == f"3.00 ± {error:.2f}"
    assert mean_with_error([0.5], "+.1f") == "+0.5"
    assert mean_with_error([None]) == rms_with_error([]) == "-"
    assert share(0, 24) == "0 of 24 (0 to 14 %)"  # Wilson's interval, n = 24
    draws = np.random.default_rng(1).normal(0, 2, (4000, 50))
    spread = np.sqrt((draws**2).mean(axis=1)).std()
    stated = [float(rms_with_error(list(draw)).split(" ± ")[1]) for draw in draws[:200]]
    assert np.mean(stated) == pytest.approx(spread, rel=0.1)


def test_a_finding_is_confirmed_only_by_more_than_its_sampling_error():
    assert verdict([1.0, 1.2, 0.8]) == "confirmed"
    assert verdict([-1.0, -1.2, -0.8]) == "contradicted"
    assert verdict([1.0, -1.0, 0.1]) == verdict([5.0]) == verdict([]) == "not decided by so few"


def test_false_edges_are_those_far_from_the_bar_s_and_kept_ones_near():
    picture = np.full((256, 300), 30, np.uint8)
    picture[:, 60:160] = 200  # the bar; further right a stripe that is none of its edges
    picture[:, 200:240] = 180
    columns = np.tile(np.array([[59.5], [159.5]]), (2, 1, 256))
    seen = _counted(picture, columns)
    assert seen.kept > 0.85  # the forest sees no edges at a picture's border
    assert seen.false == pytest.approx(2 * seen.kept, rel=0.1)
    assert _counted(picture, columns + 20).kept < 0.05


def test_a_figure_that_is_missing_is_a_dash():
    assert [number(value) for value in (None, float("nan"), 1.23456)] == ["-", "-", "1.235"]


def test_a_homography_that_sends_points_to_infinity_aligns_nothing():
    points = np.array([[10.0, 20.0], [30.0, 5.0]])
    assert _error_px(np.zeros((3, 3)), points, points) is None
    assert _error_px(np.eye(3), points + np.array([3.0, 4.0]), points) == pytest.approx(5.0)
