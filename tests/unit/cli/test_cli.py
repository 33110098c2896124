"""The commands measure, simulate, calibrate, check-config, registers and poll, and their refusals."""

import csv
import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from mill_scenes import write_line
from running import free_port

from appliance.cameras.recording.pictures import PictureRecording
from appliance.cli import main as cli
from appliance.simulation.bars.bars import bar_at
from appliance.simulation.bars.study_scenes import set_up
from appliance.sizing.reading_rows import COLUMNS

FRAMES = 3
SEED = 1


@pytest.fixture(scope="module")
def mill_folder(tmp_path_factory) -> Path:
    """A short recording of the mill and the rig that belongs to it."""
    folder = tmp_path_factory.mktemp("mill")
    write_line(folder, SEED, FRAMES)
    return folder


def said(capsys) -> str:
    """The one line on standard error."""
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("hotgauge: ")
    assert err.endswith("\n")
    assert err.count("\n") == 1
    return err


def measure(scene: Path, rig: Path, output: Path) -> int:
    return cli.main(["measure", str(scene), "--rig", str(rig), "--output", str(output)])


def test_measure_writes_json_lines_with_the_agreed_keys_and_true_diameters(mill_folder, tmp_path, capsys):
    output = tmp_path / "out.jsonl"
    assert measure(mill_folder / "scene", mill_folder / "rig.json", output) == 0
    rows = [json.loads(line) for line in output.read_text().splitlines()]
    assert [row["frame"] for row in rows] == list(range(FRAMES))
    for row in rows:
        assert list(row) == list(COLUMNS)
        assert row["valid"] is True
        assert row["reasons"] == []
        assert row["diameter_virtual_board_mm"] == pytest.approx(row["diameter_mm"], abs=0.4)
        assert row["method"] == "tangent"
        assert row["elapsed_ms"] > 0
        assert row["diameter_mm"] == pytest.approx(bar_at(SEED, row["frame"]).diameter_mm, abs=0.3)
    out, err = capsys.readouterr()
    assert out.startswith(f"{FRAMES} of {FRAMES} frames have a value\n")
    assert out.endswith(f"written to {output}\n")
    assert err == "", "a progress bar belongs on a terminal only"


def test_measure_writes_the_same_as_csv_with_empty_cells_for_no_value(mill_folder, tmp_path):
    for name in ("out.csv", "out.jsonl"):
        assert measure(mill_folder / "scene", mill_folder / "rig.json", tmp_path / name) == 0
    with (tmp_path / "out.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    lines = [json.loads(line) for line in (tmp_path / "out.jsonl").read_text().splitlines()]
    assert list(table[0]) == list(lines[0])
    for cells, row in zip(table, lines, strict=True):
        assert float(cells["diameter_mm"]) == row["diameter_mm"]
        assert cells["valid"] == "true"
        assert {name for name, cell in cells.items() if cell == ""} == {
            name for name, value in row.items() if value is None or value == []
        }


def test_a_frame_without_a_bar_is_a_row_with_reasons_and_no_value(mill_folder, tmp_path):
    scene = tmp_path / "scene"
    for side in ("left", "right"):
        (scene / side).mkdir(parents=True)
        cv2.imwrite(str(scene / side / "000007.png"), np.full((600, 800, 3), 20, np.uint8))
    for name in ("out.csv", "out.jsonl"):
        assert measure(scene, mill_folder / "rig.json", tmp_path / name) == 0
    row = json.loads((tmp_path / "out.jsonl").read_text())
    assert row["frame"] == 7
    assert row["valid"] is False
    assert row["diameter_mm"] is None
    assert row["expanded_uncertainty_mm"] is None
    assert row["reasons"]
    assert row["trust"] == 0
    cells = next(csv.DictReader((tmp_path / "out.csv").read_text().splitlines()))
    assert cells["diameter_mm"] == ""
    assert cells["reasons"] == ";".join(row["reasons"])


def refused(output: Path, capsys, *parts: str) -> None:
    line = said(capsys)
    for part in parts:
        assert part in line
    assert list(output.parent.iterdir()) == [], "nothing half-written"


@pytest.fixture
def output(tmp_path) -> Path:
    (tmp_path / "output").mkdir()
    return tmp_path / "output" / "out.jsonl"


def test_measure_names_a_missing_recording(mill_folder, output, capsys):
    assert measure(mill_folder / "absent", mill_folder / "rig.json", output) == 2
    refused(output, capsys, "absent", "give the folder of a recording")


def test_measure_names_a_missing_rig(mill_folder, output, capsys):
    assert measure(mill_folder / "scene", mill_folder / "absent.json", output) == 2
    refused(output, capsys, "absent.json", "hotgauge calibrate")


def test_measure_names_a_rig_that_is_not_one(mill_folder, tmp_path, output, capsys):
    rig = tmp_path / "rig.json"
    rig.write_text("{}")
    assert measure(mill_folder / "scene", rig, output) == 2
    refused(output, capsys, str(rig))


def test_a_truncated_picture_in_the_middle_leaves_no_output(mill_folder, tmp_path, output, capsys):
    scene = tmp_path / "scene"
    shutil.copytree(mill_folder / "scene", scene)
    broken = scene / "right" / "000002.png"
    broken.write_bytes(broken.read_bytes()[:2000])
    output.write_text("an older result\n")
    assert measure(scene, mill_folder / "rig.json", output) == 2
    assert str(broken) in said(capsys)
    assert [path.name for path in output.parent.iterdir()] == [output.name]
    assert output.read_text() == "an older result\n"


def test_a_rig_for_pictures_of_another_size_is_refused_with_both_sizes(mill_folder, tmp_path, output, capsys):
    scene = tmp_path / "scene"
    for side in ("left", "right"):
        (scene / side).mkdir(parents=True)
        cv2.imwrite(str(scene / side / "000000.png"), np.zeros((480, 640, 3), np.uint8))
    assert measure(scene, mill_folder / "rig.json", output) == 2
    refused(output, capsys, "rig.json", "800 x 600", "640 x 480")


def test_an_output_that_cannot_be_written_is_named(mill_folder, tmp_path, capsys):
    assert measure(mill_folder / "scene", mill_folder / "rig.json", tmp_path / "absent" / "out.jsonl") == 2
    assert "absent" in said(capsys)


def test_simulate_calibrate_and_measure_work_one_after_the_other(tmp_path, capsys):
    folder, rig, output = tmp_path / "line", tmp_path / "rig.json", tmp_path / "out.jsonl"
    assert cli.main(["simulate", "--output", str(folder), "--frames", "1", "--seed", "3"]) == 0
    assert cli.main(["calibrate", str(folder), "--output", str(rig)]) == 0
    assert "baseline" in capsys.readouterr().out
    (scene,) = (folder / "scenes").iterdir()
    assert measure(scene, rig, output) == 0
    row = json.loads(output.read_text())
    assert row["diameter_mm"] == pytest.approx(bar_at(3, 0).diameter_mm, abs=0.3)


def test_simulate_writes_a_condition_with_an_effect_and_its_truth(tmp_path):
    folder = tmp_path / "hazy"
    words = ["simulate", "--output", str(folder), "--scene", "haze", "--effect", "ovality", "--frames", "2"]
    assert cli.main([*words, "--seed", "5"]) == 0
    truth = json.loads((folder / "scenes" / "haze" / "truth.json").read_text())
    assert truth["condition"] == "haze"
    assert truth["frames"][1]["effects"] == ["ovality"]
    assert truth["diameter_mm"] == set_up("haze", 5, effects=["ovality"]).diameter_mm
    assert len(list((folder / "scenes" / "haze" / "left").iterdir())) == 2
    assert len(list((folder / "calibration").iterdir())) == 30


def test_simulate_writes_a_thermal_recording(tmp_path):
    folder = tmp_path / "thermal"
    assert cli.main(["simulate", "--output", str(folder), "--scene", "thermal", "--frames", "3"]) == 0
    assert (folder / "truth.json").is_file()
    assert len(list(folder.glob("*.png"))) == 8  # five of the empty line first


def test_simulate_writes_an_ingot_line_with_references_and_truth(tmp_path, capsys):
    folder = tmp_path / "line"
    assert cli.main(["simulate", "--output", str(folder), "--scene", "ingots-clean", "--frames", "20"]) == 0
    assert f"hotgauge orient {folder}/seq01 --references {folder}" in capsys.readouterr().out
    assert sorted(path.name for path in folder.iterdir()) == ["bottom.png", "roi.json", "seq01", "top.png"]
    roi = json.loads((folder / "roi.json").read_text())
    assert len(roi["roi_crop"]) == len(roi["roi_centroid"]) == 4
    with (folder / "seq01" / "truth.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["frame", "present", "label", "x", "y", "r", "state", "touch", "over"]
    assert [int(row["frame"]) for row in rows] == list(range(20))
    assert rows[0]["state"] == "empty"
    assert not rows[0]["label"]
    frames = dict(PictureRecording(folder / "seq01"))
    assert list(frames) == list(range(20))
    assert frames[0].shown.shape == (540, 960, 3)
    assert all(cv2.imread(str(folder / f"{end}.png")).shape == (64, 64, 3) for end in ("top", "bottom"))


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--scene", "ingots-glar"], ("'ingots-glar'", "ingots-glare")),
        (["--scene", "ingots", "--effect", "haze"], ("--effect",)),
    ],
)
def test_simulate_says_in_a_sentence_what_is_wrong_with_a_scene_of_ingots(tmp_path, capsys, words, named):
    assert cli.main(["simulate", "--output", str(tmp_path / "line"), *words]) == 2
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    assert all(name in message for name in named)
    assert not (tmp_path / "line").exists()


def test_simulate_names_the_scenes_that_there_are(tmp_path, capsys):
    folder = tmp_path / "x"
    assert cli.main(["simulate", "--output", str(folder), "--scene", "fog"]) == 2
    assert "'fog' is not a condition" in (line := said(capsys))
    assert "haze" in line
    assert not folder.exists()


def test_simulate_leaves_a_folder_that_holds_something_alone(tmp_path, capsys):
    (tmp_path / "mine").touch()
    assert cli.main(["simulate", "--output", str(tmp_path), "--frames", "1"]) == 2
    assert str(tmp_path) in said(capsys)
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


def test_calibrate_names_a_folder_without_pictures(tmp_path, capsys):
    assert cli.main(["calibrate", str(tmp_path), "--output", str(tmp_path / "rig.json")]) == 2
    assert "board.json" in said(capsys)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (["mesure", "x"], ("mesure", "did you mean measure?")),
        (["zzz"], ("zzz", "commands are", "check-config")),
        (["measure", "x"], ("--output",)),
        (["measure", "x", "--output", "y"], ("--rig", "hotgauge calibrate")),
        (["measure", "x", "--output", "y", "--barrier-mm", "500"], ("--barrier-mm", "--method conveyor")),
        (["registers", "--format", "xml"], ("--format", "markdown")),
        (["simulate", "--output", "x", "--frames", "-1"], ("--frames", "-1")),
        ([], ("COMMAND",)),
    ],
)
def test_a_wrong_command_line_is_one_helpful_sentence(words, parts, capsys):
    try:
        code = cli.main(words)
    except SystemExit as left:
        code = left.code
    assert code == 2
    line = said(capsys)
    for part in parts:
        assert part in line


def test_check_config_shows_what_is_in_force_so_that_it_can_be_a_settings_file(tmp_path, capsys):
    assert cli.main(["check-config"]) == 0
    file = tmp_path / "hotgauge.toml"
    file.write_text(capsys.readouterr().out)
    assert cli.main(["check-config", str(file)]) == 0
    assert "plc.port = 5020" in capsys.readouterr().out


def test_check_config_refuses_a_wrong_key(tmp_path, capsys):
    file = tmp_path / "hotgauge.toml"
    file.write_text("[plc]\nprot = 5020\n")
    assert cli.main(["check-config", str(file)]) == 2
    assert "plc.prot" in said(capsys)


@pytest.mark.parametrize("form", ["markdown", "csv", "json", "st"])
def test_the_register_map_is_printed_in_every_form(form, capsys):
    assert cli.main(["registers", "--format", form]) == 0
    assert "measurement_age" in capsys.readouterr().out


def test_poll_names_a_host_that_does_not_answer(capsys):
    unused_port = free_port()
    assert cli.main(["poll", "127.0.0.1", "--port", str(unused_port), "--count", "1"]) == 2
    assert f"127.0.0.1:{unused_port}" in said(capsys)


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_every_command_explains_itself(command, capsys):
    with pytest.raises(SystemExit) as left:
        cli.main([command, "--help"])
    assert left.value.code == 0
    assert command in capsys.readouterr().out


def test_check_config_says_what_a_host_serves_and_names_one_that_is_not_known(tmp_path, capsys):
    file = tmp_path / "hotgauge.toml"
    file.write_text('[plc]\nhost = "::"\n')
    assert cli.main(["check-config", str(file)]) == 0
    assert "every address of this computer, IPv4 and IPv6" in capsys.readouterr().out
    file.write_text('[plc]\nhost = "no-such-host.invalid"\n')
    assert cli.main(["check-config", str(file)]) == 2
    assert "plc.host: no host no-such-host.invalid is known here" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--bom"], ["--plc", "tia"], ["--format", "json", "--bom"]])
def test_registers_refuses_an_option_of_another_format(capsys, words):
    assert cli.main(["registers", *words]) == 2
    assert "give --format" in capsys.readouterr().err


def test_exchanged_views_are_named_as_the_likely_cause(mill_folder, tmp_path, capsys):
    scene = tmp_path / "scene"
    shutil.copytree(mill_folder / "scene" / "left", scene / "right")
    shutil.copytree(mill_folder / "scene" / "right", scene / "left")
    assert measure(scene, mill_folder / "rig.json", tmp_path / "out.csv") == 0
    said_out = capsys.readouterr().out
    assert said_out.startswith(f"0 of {FRAMES} frames have a value")
    assert "likely cause: left and right are exchanged" in said_out


def test_readings_are_judged_by_the_settings_and_stamped_by_the_recording(mill_folder, tmp_path, capsys):
    scene, config = tmp_path / "scene", tmp_path / "gauge.toml"
    shutil.copytree(mill_folder / "scene", scene)
    (scene / "timestamps.csv").write_text("frame,left_us,right_us\n0,1000,1001\n1,51000,51002\n2,101000,101001\n")
    true_mm = bar_at(SEED, 0).diameter_mm
    wanted = f"target_mm = {true_mm:.2f}\ntolerance_plus_mm = 2.0\ntolerance_minus_mm = 2.0\n"
    config.write_text(f"[sizing.set_points]\n{wanted}")
    words = ["measure", str(scene), "--rig", str(mill_folder / "rig.json"), "--config", str(config)]
    assert cli.main([*words, "--output", str(tmp_path / "out.csv")]) == 0
    rows = list(csv.DictReader((tmp_path / "out.csv").read_text().splitlines()))
    assert [row["time_us"] for row in rows] == ["1000", "51000", "101000"]
    assert rows[0]["decision"] == "in"
    assert abs(float(rows[0]["deviation_mm"])) < 0.3
    assert (rows[0]["bar"], rows[0]["bar_number"]) == ("0", "1")
    assert "decision: in in" in capsys.readouterr().out


def test_a_region_that_is_none_is_refused_before_any_work(tmp_path, capsys):
    assert cli.main(["calibrate", str(tmp_path), "--output", str(tmp_path / "r.json"), "--region", "100", "-100"]) == 2
    assert "--region: from 100 to -100 is no region" in said(capsys)
