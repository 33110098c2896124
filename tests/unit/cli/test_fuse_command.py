"""`hotgauge fuse`: a picture and its metrics, or one sentence and exit code 2."""

import json
import re
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.cli import main as cli
from appliance.sizing.stereo.rig_file import save_rig


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """One pair of the mill, an empty picture, and the rig."""
    folder = tmp_path_factory.mktemp("fuse")
    source = MillSource(seed=1, rate_hz=0)
    with source:
        pair = source.next(1)
    empty = np.zeros_like(pair.left)
    pictures = {"left": pair.left, "right": pair.right, "empty": empty, "grey": empty[:, :, 0], "small": empty[::2]}
    for name, picture in pictures.items():
        cv2.imwrite(str(folder / f"{name}.png"), picture)
    save_rig(mill_rig(source), folder / "rig.json")
    return folder


def fuse(folder, left, right, *words, output="fused.png"):
    paths = {"--rig": "rig.json", "--output": output}
    named = [word for name, path in paths.items() for word in (name, str(folder / path))]
    return cli.main(["fuse", str(folder / left), str(folder / right), *named, *words])


@pytest.mark.parametrize("words", [(), ("--method", "db4", "--levels", "3", "--rule", "weighted"), ("--height", "90")])
def test_a_picture_is_written_and_its_metrics_are_printed(folder, capsys, words):
    assert fuse(folder, "left.png", "right.png", *words) == 0
    out, err = capsys.readouterr()
    assert err == ""
    lines = out.splitlines()
    height_mm = re.fullmatch(r"(?:fft|db4), aligned on the plane (\S+) mm above the conveyor", lines[0])
    assert height_mm
    assert float(height_mm[1]) == 90.0 if "--height" in words else 20 < float(height_mm[1]) < 300
    where = re.fullmatch(r"both cameras see (\d+) % of the left view; metrics of (.+), (.+)", lines[1])
    assert where
    (first_column, last_column), (first_row, last_row) = (map(int, re.findall(r"\d+", where[n])) for n in (2, 3))
    assert [line.split()[0] for line in lines[3:-1]] == ["H", "SD", "SF", "AG", "FMI", "SCD", "ESSIM"]
    fused, left = (cv2.imread(str(folder / name)) for name in ("fused.png", "left.png"))
    assert fused.shape == left.shape
    cells = lines[4].split()
    common = cv2.cvtColor(fused, cv2.COLOR_BGR2GRAY)[first_row : last_row + 1, first_column : last_column + 1]
    assert common.size < 0.99 * fused[:, :, 0].size  # the cameras stand apart: no pair shares the whole picture
    assert float(cells[3]) == pytest.approx(np.std(common), abs=1e-4)


def test_as_printed_algorithm_14_has_no_strip(folder):
    pictures = []
    for words in ((), ("--as-printed",)):
        assert fuse(folder, "left.png", "right.png", "--height", "90", *words) == 0
        pictures.append(cv2.imread(str(folder / "fused.png")).astype(int))
    assert np.abs(pictures[0] - pictures[1]).mean() > 0.5  # ripples of the steps from border to border


def test_both_aligned_views_and_edges_are_drawn(folder, tmp_path):
    assert fuse(folder, "left.png", "right.png", "--plot", str(tmp_path / "plots")) == 0
    drawn = {path.stem: cv2.imread(str(path)) for path in (tmp_path / "plots").iterdir()}
    assert set(drawn) == {"left", "right_aligned", "pair", "edges"}
    left, right = (cv2.cvtColor(drawn[name], cv2.COLOR_BGR2GRAY) for name in ("left", "right_aligned"))
    assert np.array_equal(drawn["pair"][..., 2], left)
    assert np.array_equal(drawn["pair"][..., 0], right)
    alone, together = drawn["edges"][..., 2] == 255, drawn["edges"][..., 1] == 255
    assert min(alone.sum(), together.sum()) > 500
    assert (alone & together).sum() > 0.3 * alone.sum()  # the bar's own edges stay where they were


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (("right.png", ("--method", "db3"), "x.png"), "--method: there is no db3; did you mean db"),
        (("right.png", ("--levels", "2"), "x.png"), "--method: fft has neither levels nor rules; db2, "),
        (("right.png", ("--method", "db2", "--levels", "0"), "x.png"), "--levels: 0 is less than 1"),
        (("right.png", (), "x.gif"), "x.gif: is neither PNG nor JPEG; let its name end in .png, "),
        (("right.png", (), "nowhere/x.png"), "x.png: there is no folder "),
        (("empty.png", (), "x.png"), "outlines of a bar agree: only one view shows a bar across"),
        (("nothing.png", (), "x.png"), "nothing.png: cannot be read (No such file or directory)"),
        (("small.png", (), "x.png"), "small.png is 800 x 300; use its own rig"),
        (("grey.png", (), "x.png"), "grey.png: one picture is grey and the other in colour"),
    ],
)
def test_trouble_is_one_sentence(folder, capsys, asked, said):
    right, words, output = asked
    assert fuse(folder, "left.png", right, *words, output=output) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("hotgauge: ")
    assert err.count("\n") == 1
    assert said in err
    assert not (folder / output).exists()


def measure(folder, *words):
    return cli.main(["measure", str(folder / "scene"), "--rig", str(folder / "rig.json"), *words])


@pytest.fixture(scope="module")
def scene(folder):
    for side in ("left", "right"):
        (folder / "scene" / side).mkdir(parents=True)
        shutil.copy(folder / f"{side}.png", folder / "scene" / side / "000000.png")
    return folder


def test_measure_takes_the_fusion_that_it_is_given(scene, tmp_path):
    def diameter_mm(*words):
        output = tmp_path / "readings.jsonl"
        assert measure(scene, "--output", str(output), "--method", "virtual-board", "--edges", "sobel", *words) == 0
        return json.loads(output.read_text())["diameter_mm"]

    assert diameter_mm() == diameter_mm("--fusion", "none")
    assert diameter_mm("--fusion", "fft") == pytest.approx(diameter_mm(), abs=1.0)
    assert len({diameter_mm("--fusion", name) for name in ("none", "fft", "fk4")}) == 3


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--fusion", "fft"), "--fusion: only virtual boards have it; add --method virtual-board"),
        (("--method", "virtual-board", "--fusion", "haar"), "--fusion: there is no haar; there are none, fft, db2, "),
    ],
)
def test_a_fusion_that_cannot_be_is_one_sentence(scene, capsys, words, said):
    assert measure(scene, "--output", str(scene / "x.csv"), *words) == 2
    assert said in capsys.readouterr().err
    assert not (scene / "x.csv").exists()
