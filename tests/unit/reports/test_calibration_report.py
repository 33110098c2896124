"""The report of a calibration from the pictures of `line_a`, whose cameras are known; and its refusals."""

import json
import re

import numpy as np
import pytest

from appliance.cli.main import main
from appliance.reports.calibration_charts import curve_u
from vision.calibration.response import MeasuredResponse
from vision.light import ResponseCurve


def test_the_report_states_what_the_pictures_of_line_a_show(recordings, tmp_path, capsys):
    """Every picture, every pose left out, and an uncertainty from leaving out of the size of the stated one."""
    output = tmp_path / "calibration.html"
    words = ["calibrate", str(recordings / "line_a"), "--output", str(tmp_path / "rig.json"), "--report", str(output)]
    assert main(words) == 0
    assert f"report        {output}" in capsys.readouterr().out
    html = output.read_text()
    assert "Calibration of two cameras: good" in html
    assert html.count('<img src="data:image/svg+xml;base64,') == 4
    assert "http" not in re.sub(r'src="data:[^"]*"', "", html)  # nothing is fetched from elsewhere
    poses = re.findall(r"<tr><td>(\w+)</td><td class=\"n\">0\.\d{3} px</td><td class=\"n\">0\.\d{3} px</td></tr>", html)
    assert poses == [*(f"{number:02d}" for number in range(15)), "high", "low"]
    row = html.split("left focal length</td>")[1]
    value, u, left_out_u = (float(text) for text in re.findall(r'class="n">([\d.]+) px', row)[:3])
    truth = json.loads((recordings / "line_a" / "truth_rig.json").read_text())["cameras"]["left"]["K"][0][0]
    assert value == pytest.approx(truth, abs=3 * u)
    assert u / 3 < left_out_u < 3 * u  # the jackknife of 15 poses scatters by about a third


@pytest.mark.parametrize(
    ("report", "words"),
    [
        ("report.txt", "give a name that ends in .html or .pdf"),
        ("absent/report.html", "there is no folder"),
        ("rig.html", "is the rig file too"),
    ],
)
def test_a_report_that_cannot_be_written_is_refused_before_the_work(tmp_path, capsys, report, words):
    rig = tmp_path / "rig.html"
    assert main(["calibrate", str(tmp_path), "--output", str(rig), "--report", str(tmp_path / report)]) == 2
    said = capsys.readouterr().err
    assert "--report" in said
    assert words in said
    assert not rig.exists()


def test_the_band_of_the_response_is_the_scatter_of_drawn_curves():
    """Against curves drawn from the covariance: no linear propagation of our own."""
    covariance = np.diag([0.1, 0.004, 0.02]) ** 2
    measured = MeasuredResponse(ResponseCurve(2.2, 0.01, 0.05, covariance), 0.0, 0.001, 30)
    codes = np.array([0.2, 0.5, 0.8])
    drawn = np.random.default_rng(2).multivariate_normal([2.2, 0.01, 0.05], covariance, 4000)
    scatter = np.std([ResponseCurve(*one).light(codes) for one in drawn], axis=0)
    assert curve_u(measured, codes) == pytest.approx(scatter, rel=0.1)
