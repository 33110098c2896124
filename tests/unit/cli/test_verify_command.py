"""`hotgauge verify`: verdict, drift, certificate and the row in the history; most readings are of a stand-in gauge."""

import csv
import math
import random
import statistics

import pytest
from mill_scenes import write_line

from appliance.cli.main import main
from appliance.simulation.bars.bars import bar_at
from appliance.verification import certificate
from appliance.verification.check import Master, verdict, verify
from appliance.verification.measure import read_master


@pytest.mark.parametrize(
    ("error_mm", "expected"),
    [(0.0, "pass"), (0.15, "pass"), (-0.15, "pass"), (0.16, "undecided"), (-0.2, "undecided"), (0.24, "undecided"),
     (0.25, "fail"), (-0.3, "fail")],
)  # fmt: skip
def test_the_guard_band_stands_on_both_sides_of_the_limit(error_mm, expected):
    assert verdict(error_mm, test_expanded_mm=0.05, limit_mm=0.2) == expected


def test_an_error_is_known_as_well_as_the_master_and_the_scatter_let_it():
    source = random.Random(4)
    readings = [250.1 + source.gauss(0, 0.06) for _ in range(36)]
    found = verify(readings, 2, Master(250.0, 0.03), 0.2, [])
    scatter_mm = statistics.stdev(readings)
    assert found.error_mm == pytest.approx(statistics.mean(readings) - 250)
    assert found.repeatability_mm == pytest.approx(scatter_mm)
    assert found.test_expanded_mm == pytest.approx(2 * math.sqrt(0.015**2 + scatter_mm**2 / 36))
    assert math.isnan(found.drift_mm)


def test_a_faultless_gauge_passes_and_the_stated_u_of_its_error_holds_in_95_of_100():
    source = random.Random(8)
    held = 0
    for _ in range(1000):
        true_mm = 250 + source.gauss(0, 0.02)  # the master's U is 0.04
        found = verify([true_mm + source.gauss(0, 0.05) for _ in range(20)], 0, Master(250.0, 0.04), 0.2, [])
        held += abs(found.error_mm) <= found.test_expanded_mm
        assert found.verdict == "pass"
    assert held / 1000 == pytest.approx(0.95, abs=0.02)


def test_drift_is_counted_from_the_first_verification_on_a_like_master():
    readings = [100.2, 100.3] * 10
    earlier = [(250.0, 9.0), (100.1, 0.05), (99.9, 0.15)]
    assert verify(readings, 0, Master(100.0, 0), 1, earlier).drift_mm == pytest.approx(0.2)


def test_too_few_readings_and_no_limit_are_wrong_calls():
    with pytest.raises(ValueError, match="10 are needed"):
        verify([100.0] * 9, 0, Master(100.0, 0), 1, [])
    with pytest.raises(ValueError, match="limit_mm"):
        verify([100.0] * 10, 0, Master(100.0, 0), 0, [])


@pytest.fixture
def verified(tmp_path, monkeypatch):
    """Runs the command with readings of choice; its exit code."""
    (tmp_path / "rig.json").write_text("{}")
    (tmp_path / "hotgauge.toml").write_text('[history]\ndirectory = "history"\n')

    def run(*more: str, error_mm: float = 0.0, readings: int = 20) -> int:
        diameters = [250 + error_mm + (0.01 if k % 2 else -0.01) for k in range(readings)]
        monkeypatch.setattr(certificate, "read_master", lambda *_: (diameters, 1, 0.15))
        rig, config = str(tmp_path / "rig.json"), str(tmp_path / "hotgauge.toml")
        return main(["verify", "--rig", rig, "--diameter", "250", "--config", config, *more, "master"])

    return run


def test_the_verdict_is_the_exit_code_and_the_limit_is_the_stated_u_unless_given(verified, capsys):
    assert verified(error_mm=0.1) == 0
    assert "permissible error 0.150 mm" in capsys.readouterr().out
    assert verified(error_mm=0.3) == 1
    assert "verdict         fail" in capsys.readouterr().out
    assert verified("--limit", "0.5", error_mm=0.3) == 0


def test_each_verification_is_kept_and_the_next_one_knows_the_drift(verified, tmp_path, capsys):
    verified("--who", "A. Smith", "--u", "0.02", error_mm=0.05)
    assert "no earlier verification" in capsys.readouterr().out
    verified(error_mm=0.12)
    assert "drift           +0.070 mm" in capsys.readouterr().out
    words = ["export", "--what", "verifications", "--from", "2020-01-01", "--to", "2100-01-01"]
    main([*words, "--config", str(tmp_path / "hotgauge.toml"), "--output", str(tmp_path / "out.csv")])
    with (tmp_path / "out.csv").open(newline="") as file:
        first, second = csv.DictReader(file)
    assert (first["who"], first["verdict"], first["missing"]) == ("A. Smith", "pass", "1")
    assert float(first["master_expanded_mm"]) == 0.02
    assert len(first["rig_sha256"]) == 64
    assert float(second["drift_mm"]) == pytest.approx(0.07)


def test_the_certificate_says_what_was_found(verified, tmp_path):
    assert verified("--output", str(tmp_path / "out.html"), "--who", "A. Smith", error_mm=0.3) == 1
    html = (tmp_path / "out.html").read_text()
    for words in ("FAIL", "+0.300 mm", "0.150 mm, either way", "A. Smith", "ISO 14253-1", "1 without"):
        assert words in html


@pytest.mark.parametrize(
    ("more", "readings", "said"),
    [((), 9, "10 are needed; record the master for longer"), (("--output", "out.doc"), 20, "ends in .pdf or .html")],
)
def test_what_cannot_be_verified_is_refused_in_a_sentence(verified, capsys, more, readings, said):
    assert verified(*more, readings=readings) == 2
    assert said in capsys.readouterr().err


def test_the_readings_are_those_of_the_recording(tmp_path):
    write_line(tmp_path, seed=1, frames=3)
    done = []
    diameters, missing, expanded_mm = read_master(
        tmp_path / "scene", tmp_path / "rig.json", lambda *now: done.append(now)
    )
    truth = [bar_at(1, frame).diameter_mm for frame in range(3)]
    assert diameters == pytest.approx(truth, abs=0.3)
    assert missing == 0
    assert 0 < expanded_mm < 1
    assert len(done) == 3
