"""The gauge study against the worked example of AIAG's Measurement Systems Analysis, 4th edition."""

import random

import pytest

from appliance.cli.main import main
from appliance.verification.gauge_study import gauge_study

EXAMPLE = {  # ten parts, three appraisers, three trials
    "A": (
        (0.29, -0.56, 1.34, 0.47, -0.80, 0.02, 0.59, -0.31, 2.26, -1.36),
        (0.41, -0.68, 1.17, 0.50, -0.92, -0.11, 0.75, -0.20, 1.99, -1.25),
        (0.64, -0.58, 1.27, 0.64, -0.84, -0.21, 0.66, -0.17, 2.01, -1.31),
    ),
    "B": (
        (0.08, -0.47, 1.19, 0.01, -0.56, -0.20, 0.47, -0.63, 1.80, -1.68),
        (0.25, -1.22, 0.94, 1.03, -1.20, 0.22, 0.55, 0.08, 2.12, -1.62),
        (0.07, -0.68, 1.34, 0.20, -1.28, 0.06, 0.83, -0.34, 2.19, -1.50),
    ),
    "C": (
        (0.04, -1.38, 0.88, 0.14, -1.46, -0.29, 0.02, -0.46, 1.77, -1.49),
        (-0.11, -1.13, 1.09, 0.20, -1.07, -0.67, 0.01, -0.56, 1.45, -1.77),
        (-0.15, -0.96, 0.67, 0.11, -1.45, -0.49, 0.21, -0.49, 1.87, -2.16),
    ),
}
CELLS = {(str(part), name): [trial[part] for trial in trials] for name, trials in EXAMPLE.items() for part in range(10)}


def test_figures_are_those_of_the_worked_example():
    found = gauge_study(CELLS)
    assert (found.bars, found.conditions, found.trials) == (10, 3, 3)
    assert found.repeatability_mm == pytest.approx(0.199933, abs=1e-5)
    assert found.reproducibility_mm == pytest.approx(0.226838, abs=1e-5)
    assert found.gauge_mm == pytest.approx(0.302373, abs=1e-5)
    assert found.bars_mm == pytest.approx(1.042327, abs=1e-5)
    assert found.categories == 4
    assert found.percent_of_variation == pytest.approx(27.9, abs=0.05)


def test_what_was_put_in_comes_out_with_an_interaction_too():
    source = random.Random(3)
    bars = [source.gauss(0, 2.0) for _ in range(200)]
    places = [source.gauss(0, 0.3) for _ in range(200)]
    cells = {
        (str(b), str(p)): [bars[b] + places[p] + extra + source.gauss(0, 0.1) for _ in range(2)]
        for b in range(200)
        for p in range(200)
        for extra in [source.gauss(0, 0.2)]
    }
    found = gauge_study(cells)
    assert found.repeatability_mm == pytest.approx(0.1, rel=0.03)
    assert found.reproducibility_mm == pytest.approx((0.3**2 + 0.2**2) ** 0.5, rel=0.1)
    assert found.bars_mm == pytest.approx(2.0, rel=0.15)


def test_the_command_reads_a_table(tmp_path, capsys):
    file = tmp_path / "study.csv"
    lines = [f"{bar},{condition},{value}" for (bar, condition), values in CELLS.items() for value in values]
    file.write_text("\n".join(["bar,condition,diameter_mm", *lines]))
    assert main(["gauge-study", str(file), "--tolerance", "10"]) == 0
    said = capsys.readouterr().out
    assert "GRR  0.3024 mm, 27.9 %" in said
    assert "of the tolerance      18.1 %" in said


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("bar,condition,diameter_mm\n1,a,2\n1,a,3\n2,a,1\n2,a,1\n", "two bars and two conditions"),
        ("bar,diameter_mm\n1,2\n", "it needs the columns"),
        ("bar,condition,diameter_mm\n1,a,x\n", "with numbers"),
    ],
)
def test_what_is_no_study_is_refused_in_a_sentence(tmp_path, capsys, text, said):
    (tmp_path / "study.csv").write_text(text)
    assert main(["gauge-study", str(tmp_path / "study.csv")]) == 2
    assert said in capsys.readouterr().err
