"""What `measure --plot` draws, looked at as a picture: there, not empty, and one for every kind."""

import cv2
import pytest

from appliance import cli


@pytest.fixture(scope="module")
def line(tmp_path_factory):
    folder = tmp_path_factory.mktemp("line")
    assert cli.main(["simulate", "--output", str(folder / "sim"), "--frames", "3", "--seed", "2"]) == 0
    assert cli.main(["calibrate", str(folder / "sim"), "--output", str(folder / "rig.json")]) == 0
    return folder


def measure(line, *options):
    recording = next((line / "sim" / "scenes").iterdir())
    return cli.main(["measure", str(recording), "--rig", str(line / "rig.json"), *options])


def test_virtual_boards_are_measured_and_drawn(line):
    output, plots = line / "v.csv", line / "plots"
    assert (
        measure(line, "--method", "virtual-board", "--edges", "sobel", "--output", str(output), "--plot", str(plots))
        == 0
    )
    header, *rows = output.read_text().splitlines()
    assert len(rows) == 3
    assert "diameter_virtual_board_mm" in header
    pictures = [cv2.imread(str(path)) for path in sorted(plots.glob("*.png"))]
    assert len(pictures) >= 2
    assert all(picture.std() > 5 for picture in pictures)


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
