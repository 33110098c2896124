"""`train-edges`: the model file and the record beside it, and the scenes that it draws."""

import json

import cv2
import numpy as np
import pytest
from scipy import io

from appliance.cli import main as cli
from appliance.simulation.bars.bars import Bar
from appliance.simulation.true_rig import default_rig
from appliance.training import edge_scenes
from appliance.training.edge_scenes import CROP_PX, UNKNOWN_SEGMENT, edge_examples
from vision.edges.forest.model import StructuredForest


@pytest.fixture
def bsds(tmp_path):
    """Four small pictures, two people each, in the layout of BSDS500."""
    rng = np.random.default_rng(1)
    for kind in ("images", "groundTruth"):
        (tmp_path / kind / "train").mkdir(parents=True)
    for number in range(4):
        column = int(rng.integers(40, 80))
        segments = np.ones((80, 120), np.uint16)
        segments[:, column:] = 2
        picture = np.where(segments[..., None] == 2, (40, 120, 220), (90, 60, 20)).astype(np.uint8)
        cv2.imwrite(str(tmp_path / "images" / "train" / f"{number}.jpg"), picture)
        people = np.empty((1, 2), object)
        for person in range(2):
            people[0, person] = {"Segmentation": segments, "Boundaries": np.zeros_like(segments, np.uint8)}
        io.savemat(tmp_path / "groundTruth" / "train" / f"{number}.mat", {"groundTruth": people})
    return tmp_path


def test_a_model_and_how_it_was_made_are_written_and_the_same_seed_writes_the_same(bsds, tmp_path, capsys):
    models = []
    for name in ("one", "two"):
        output = tmp_path / f"{name}.npz"
        words = ["train-edges", "--bsds", str(bsds), "--output", str(output), "--patches", "200", "--seed", "5"]
        assert cli.main(words) == 0
        models.append(StructuredForest.load(output))
        record = json.loads(output.with_suffix(".json").read_text())
        assert record["seed"] == 5
        assert record["data"] == "BSDS500 train"
        assert record["nodes"] == len(models[-1].left_children)
    assert "8 trees of 200 patches" in capsys.readouterr().out
    assert models[0].trees == 8
    assert np.array_equal(models[0].thresholds, models[1].thresholds)
    assert np.array_equal(models[0].edge_places, models[1].edge_places)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--output", "nowhere/model.npz"], "nowhere: no such folder"),
        (["--output", "model.dat"], r"model.dat: a model's name ends in .npz"),
        (["--output", "model.npz", "--bsds", "elsewhere"], "elsewhere: no pictures in images/train"),
    ],
)
def test_trouble_is_told_in_one_sentence_before_anything_is_trained(words, sentence, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["train-edges", *words]) == 2
    told = capsys.readouterr().err
    assert sentence in told
    assert told.count("\n") == 1


def test_a_picture_without_ground_truth_and_a_damaged_one_are_named(bsds, capsys):
    truth = bsds / "groundTruth" / "train" / "2.mat"
    words = ["train-edges", "--bsds", str(bsds), "--output", str(bsds / "model.npz"), "--patches", "50"]
    truth.write_bytes(b"nothing")
    assert cli.main(words) == 2
    assert "2.mat: no ground truth as BSDS500 has it" in capsys.readouterr().err
    truth.unlink()
    assert cli.main(words) == 2
    assert "2.jpg: its ground truth" in capsys.readouterr().err


def test_the_same_seed_draws_the_same_examples_and_some_of_each_kind():
    first, again, other = (list(edge_examples(seed, 14)) for seed in (3, 3, 4))
    assert len(first) == 14
    for one, same in zip(first, again, strict=True):
        assert np.array_equal(one.image, same.image)
        assert np.array_equal(one.segments[0], same.segments[0])
    assert not np.array_equal(first[0].image, other[0].image)
    assert {one.image.ndim for one in first} == {2, 3}
    assert any((one.segments[0] == UNKNOWN_SEGMENT).any() for one in first)
    for one in first:
        assert one.image.shape[:2] == one.segments[0].shape == (CROP_PX, CROP_PX)
        assert one.image.dtype == np.float32
        assert 0 <= one.image.min() <= one.image.max() <= 1


def test_borders_of_segments_lie_where_the_picture_is_steep():
    slope_at = np.zeros(9)  # from four pixels on the dark side of a border to four on the bright one
    for example in edge_examples(8, 30):
        image = example.image if example.image.ndim == 2 else example.image.max(axis=2)
        segments = example.segments[0].astype(int)
        step = (segments[:, 1:] != segments[:, :-1]) & (segments[:, 1:] >= 0) & (segments[:, :-1] >= 0)
        rows, columns = np.nonzero(step[:, 6:-6])
        slope = np.diff(image, axis=1)
        brighter = np.sign(image[rows, columns + 6 + 3] - image[rows, columns + 6 - 2]).astype(int)
        for place in range(-4, 5):
            slope_at[place + 4] += (brighter * slope[rows, columns + 6 + brighter * place]).sum()
    assert np.argmax(slope_at) == 4
    # codes are steepest a little on the dark side of where light is halfway
    assert np.average(np.arange(-2, 3), weights=slope_at[2:7]) == pytest.approx(-0.1, abs=0.2)


def test_crops_lie_in_the_picture_and_are_of_its_scale():
    """Corners and sides of each crop by geometry: straight, not larger than 1.2 or smaller than 0.5 pixels a step."""
    camera = default_rig().left
    columns, rows = camera.image_size
    for seed in range(300):
        places = edge_scenes._places(camera, Bar(150.0), np.array([[5.0, 5.0]]), np.random.default_rng(seed))
        assert places.min() >= 0
        assert places[..., 0].max() <= columns - 1
        assert places[..., 1].max() <= rows - 1
        steps_px = np.linalg.norm(places[0, 1] - places[0, 0]), np.linalg.norm(places[1, 0] - places[0, 0])
        assert 0.5 - 1e-9 <= min(steps_px) <= max(steps_px) <= 1.2 + 1e-9
