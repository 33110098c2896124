"""The network of relief: its slopes are those of its loss, and it learns what it is shown."""

import numpy as np
import pytest

from appliance.simulation.ingots.cast_faces import cast_face
from appliance.simulation.ingots.faces import LABELS
from appliance.training import ingot_relief
from appliance.training.ingot_relief import (
    Batch,
    batch_of,
    first_layers,
    loss_and_slopes,
    train,
    trained,
    write,
)
from appliance.training.rendered_ends import RenderedLine, random_camera, rendered_end, rendered_line
from vision.ingot.classifiers.classifier import Face
from vision.ingot.classifiers.relief import MODEL, ReliefOdds, relief

SIDE = 64


def log_odds(judge, image):
    return judge.judge(Face(image, 0.0, 0.0)).log_odds


def test_slopes_are_those_of_the_loss():
    rng = np.random.default_rng(0)
    layers = [(weights.astype(np.float64), bias + 0.1) for weights, bias in first_layers(rng)]
    batch = Batch(rng.standard_normal((6, SIDE, SIDE, 3)), np.array([2, 4]), np.array([3, 3]), np.array([0.0, 1.0]))
    _, slopes = loss_and_slopes(layers, batch)
    parameters = [one for pair in layers for one in pair]
    for one, slope in zip(parameters, slopes, strict=True):
        assert slope.shape == one.shape
        place = np.unravel_index(np.argmax(np.abs(slope)), one.shape)
        losses = []
        for step in (1e-6, -2e-6):
            one[place] += step
            losses.append(loss_and_slopes(layers, batch)[0])
        one[place] += 1e-6
        assert (losses[0] - losses[1]) / 2e-6 == pytest.approx(slope[place], rel=1e-2)


def line_of_bars(rng):
    """A line whose tops show a dark bar."""
    tops = np.arange(6) % 2 == 0
    ends = rng.normal(120, 3, (8, SIDE, SIDE))
    ends[np.append([True, False], tops), 28:34, 16:48] -= 40
    ends = ends.astype(np.uint8)
    return RenderedLine(ends[:2], ends[2:], tops)


@pytest.fixture
def small_batches(monkeypatch):
    monkeypatch.setattr(ingot_relief, "LINES_A_BATCH", 6)


@pytest.mark.usefixtures("small_batches")
def test_it_learns_what_tops_of_its_lines_have_in_common():
    rng = np.random.default_rng(1)
    lines = [line_of_bars(rng) for _ in range(20)]
    layers = first_layers(rng)
    train(layers, lines, 25, rng)
    loss, _ = loss_and_slopes(layers, batch_of(lines, rng))
    assert loss < 0.3


@pytest.mark.usefixtures("small_batches")
def test_the_command_gives_the_same_file_again(tmp_path):
    for name in ("first.npz", "second.npz"):
        write(trained(lines=2, steps=2), tmp_path / name)
    assert (tmp_path / "first.npz").read_bytes() == (tmp_path / "second.npz").read_bytes()


def test_the_network_that_is_shipped_is_small_and_of_the_shape_that_the_command_trains():
    assert MODEL.stat().st_size < 1_000_000
    with np.load(MODEL) as model:
        shapes = [model[f"{kind}{number}"].shape for number in range(6) for kind in "Wb"]
    assert shapes == [one.shape for pair in first_layers(np.random.default_rng(0)) for one in pair]


def test_the_network_that_is_shipped_tells_ends_of_lines_it_has_not_seen():
    right = []
    for number in range(12):
        line = rendered_line(np.random.default_rng([424242, number]), faces=6, views=1)
        judge = ReliefOdds(*line.references)
        right += [(log_odds(judge, end) > 0) == top for end, top in zip(line.ends, line.tops, strict=True)]
    assert np.mean(right) >= 0.9


def test_the_network_that_is_shipped_tells_ends_of_a_kind_it_was_not_trained_on():
    right = []
    for number in range(12):
        rng = np.random.default_rng([434343, number])
        camera = random_camera(rng)
        *references, top, bottom = (rendered_end(cast_face(label, rng), camera, rng) for label in LABELS * 2)
        judge = ReliefOdds(*references)
        right += [log_odds(judge, top) > 0, log_odds(judge, bottom) < 0]
    assert np.mean(right) >= 0.9


def test_an_end_and_its_mirror_images_have_the_same_odds():
    line = rendered_line(np.random.default_rng(7), faces=2, views=1)
    judge, image = ReliefOdds(*line.references), line.ends[0]
    images = (image, image[::-1], image[:, ::-1], image[::-1, ::-1])
    odds = [judge.log_odds(np.ascontiguousarray(one)) for one in images]
    assert odds == pytest.approx([odds[0]] * 4, abs=1e-3)


def test_exposure_changes_no_relief_and_what_is_clipped_shows_none():
    rng = np.random.default_rng(5)
    image = np.clip(rng.normal(120, 8, (SIDE, SIDE)), 0, 255).astype(np.uint8)
    brighter = np.rint(1.2 * image).astype(np.uint8)
    assert relief(brighter)[..., :2] == pytest.approx(relief(image)[..., :2], abs=0.25)
    assert not relief(np.full((SIDE, SIDE), 255, np.uint8)).any()
