"""What `measure --plot` draws, looked at as a picture: there, not empty, and one for every kind."""

import cv2
import numpy as np
import pytest
from mill_scenes import write_line

from appliance.cli import main as cli
from appliance.simulation.bars.bars import Bar
from appliance.simulation.thermal_line import ThermalLine, thermal_camera
from appliance.simulation.write_recording import write_thermal_recording


@pytest.fixture(scope="module")
def line(tmp_path_factory):
    folder = tmp_path_factory.mktemp("line")
    write_line(folder, seed=2, frames=3)
    return folder


def measure(line, *options):
    return cli.main(["measure", str(line / "scene"), "--rig", str(line / "rig.json"), *options])


def test_virtual_boards_are_measured_and_drawn(line):
    output, plots = line / "v.csv", line / "plots"
    assert (
        measure(line, "--method", "virtual-board", "--edges", "sobel", "--output", str(output), "--plot", str(plots))
        == 0
    )
    header, *rows = output.read_text().splitlines()
    assert len(rows) == 3
    assert "diameter_virtual_board_mm" in header
    pictures = {path.stem: cv2.imread(str(path)) for path in sorted(plots.glob("*.png"))}
    assert all(picture.std() > 5 for picture in pictures.values())
    assert {"frames", "alignment", "boundaries_000000", "alignment_000000"} <= set(pictures)
    green = (np.abs(pictures["boundaries_000000"].astype(int) - (60, 220, 60)) < 3).all(axis=2)
    rows, columns = np.nonzero(green)
    middle = columns.mean()
    assert len(np.unique(rows)) > 0.8 * len(green)  # an edge point in most rows, on both sides of the bar
    assert min((columns < middle).sum(), (columns > middle).sum()) > 0.3 * len(green)
    blue, _, red = np.moveaxis(pictures["boundaries_000000"].astype(int), 2, 0)
    assert (blue - red).max() < 20, "the band of a detector that did not measure here"
    both = pictures["alignment_000000"].astype(int)
    bright = both.max(axis=2) > 120
    assert np.abs(both[..., 2] - both[..., 0])[bright].mean() < 60  # on the plane of the bar red and cyan make grey


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--method", "virtual-board", "--edges", "sobl"), "sobel"),
        (("--method", "virtual-board", "--fusion", "ftt"), "fft"),
        (("--edges", "sobel"), "add --method virtual-board"),
    ],
)
def test_a_typo_is_one_sentence(line, capsys, options, said):
    assert measure(line, *options, "--output", str(line / "x.csv")) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not (line / "x.csv").exists()


def test_a_conveyor_is_measured_and_drawn(tmp_path, capsys):
    line = ThermalLine(thermal_camera(), bar=Bar(165.0, 20.0), seed=1)
    write_thermal_recording(tmp_path / "thermal", line, empty=2, frames=3)
    output, plots = tmp_path / "sizes.csv", tmp_path / "plots"
    words = ["measure", str(tmp_path / "thermal"), "--method", "conveyor", "--barrier-mm", "500"]
    assert cli.main([*words, "--output", str(output), "--plot", str(plots)]) == 0
    assert "--response-exponent" in capsys.readouterr().out
    assert len(output.read_text().splitlines()) == 6
    assert cli.main([*words, "--response-exponent", "1", "--output", str(output)]) == 0
    assert "--response-exponent" not in capsys.readouterr().out
    rows = [row.split(",") for row in (plots / "experiments.csv").read_text().splitlines()[1:]]
    assert {row[0] for row in rows} == {"1", "2", "3", "4"}
    assert len(rows) == 4 * 3
    assert all(abs(float(row[2]) - 165.0) < 8 and 0 <= float(row[3]) < 8 for row in rows)
    pictures = {path.name: cv2.imread(str(path)) for path in plots.glob("*.png")}
    assert set(pictures) == {"experiments.png", "frames.png"}
    assert all(picture.std() > 5 for picture in pictures.values())
    left, right = np.array_split(pictures["experiments.png"], 2, axis=1)
    for half in (left, right):  # two experiments each, in the colours of the first two
        for colour in ((180, 119, 31), (14, 127, 255)):
            assert np.count_nonzero((np.abs(half.astype(int) - colour) < 30).all(axis=2)) > 100


def test_a_conveyor_without_any_bar_is_drawn_too(tmp_path):
    write_thermal_recording(tmp_path / "thermal", ThermalLine(thermal_camera(), seed=1), empty=2, frames=1)
    words = ["measure", str(tmp_path / "thermal"), "--method", "conveyor", "--barrier-mm", "500"]
    assert cli.main([*words, "--output", str(tmp_path / "x.csv"), "--plot", str(tmp_path / "plots")]) == 0
    assert len(list((tmp_path / "plots").glob("*.png"))) == 2


def test_the_served_method_is_drawn_with_its_uncertainty_its_decisions_and_its_parts(line, tmp_path):
    config = tmp_path / "wanted.toml"
    config.write_text("[sizing.set_points]\ntarget_mm = 100\ntolerance_plus_mm = 4\ntolerance_minus_mm = 4\n")
    plots = tmp_path / "plots"
    options = ["--config", str(config), "--plot", str(plots)]
    assert measure(line, "--output", str(tmp_path / "t.csv"), *options) == 0
    pictures = {path.name: cv2.imread(str(path)).astype(int) for path in plots.iterdir()}
    assert pictures.keys() == {"diameter.png", "uncertainty.png"}
    out_of_tolerance = (np.abs(pictures["diameter.png"] - (0x00, 0x5E, 0xD5)) < 3).all(axis=2)
    assert out_of_tolerance.sum() > 50
    print_of_the_board = (np.abs(pictures["uncertainty.png"] - (0x73, 0x9E, 0x00)) < 3).all(axis=2)
    assert print_of_the_board.sum() > 1000
