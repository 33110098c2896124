"""The edge network: its slopes are those of its loss, it learns a step, and OpenCV runs what was trained."""

import numpy as np
import pytest
from edge_network_on_opencv import EdgeNetwork

from appliance.training import edge_network
from appliance.training.edge_network import CELL_PX, LAYERS, Examples, first_weights, loss_and_slopes, outlines
from appliance.training.edge_scenes import CROP_PX


def steps(rng, count):
    """Crops with one upright step of light each."""
    columns = rng.integers(60, 100, count)
    bright = np.arange(CROP_PX) >= columns[:, None, None]
    images = np.where(np.repeat(bright, CROP_PX, axis=1), 0.8, 0.1)[..., None] * np.ones(3)
    images = images + rng.normal(0, 0.01, images.shape)
    segments = np.repeat(bright, CROP_PX, axis=1).astype(np.int16)
    edges = np.stack([outlines(one) for one in segments])
    return Examples(images.clip(0, 1).astype(np.float16), edges, np.ones(edges.shape, np.float16))


def test_an_outline_is_both_pixels_beside_a_border_that_is_known():
    segments = np.array([[1, 1, 2, 2], [1, 1, 2, -1], [1, 1, -1, -1]])
    assert outlines(segments).tolist() == [[0, 1, 1, 0], [0, 1, 1, 0], [0, 0, 0, 0]]


def test_slopes_are_those_of_the_loss():
    rng = np.random.default_rng(0)
    weights = [(kernels.astype(np.float64), bias + 0.1) for kernels, bias in first_weights(rng)]
    batch = Examples(*(part[:2, :24, :24] for part in steps(rng, 2)))
    batch = batch._replace(edges=(rng.random(batch.edges.shape) < 0.1).astype(np.uint8))
    _, slopes = loss_and_slopes(weights, batch)
    for one, slope in zip((part for pair in weights for part in pair), slopes, strict=True):
        place = np.unravel_index(np.argmax(np.abs(slope)), slope.shape)
        losses = []
        for step in (1e-6, -2e-6):
            one[place] += step
            losses.append(loss_and_slopes(weights, batch)[0])
        one[place] += 1e-6
        assert (losses[0] - losses[1]) / 2e-6 == pytest.approx(slope[place], rel=1e-2)


def test_it_learns_a_step_and_opencv_runs_what_was_trained(tmp_path, monkeypatch):
    monkeypatch.setattr(edge_network, "EXAMPLES_A_BATCH", 2)
    monkeypatch.setattr(edge_network, "WARM_STEPS", 5)
    rng = np.random.default_rng(1)
    weights, examples = first_weights(rng), steps(rng, 6)
    edge_network.train(weights, examples, 60, rng)
    edge_network.write(weights, tmp_path / "edges.onnx")
    image = examples.images[0].astype(np.float32)
    strength = EdgeNetwork(tmp_path / "edges.onnx").strength(image[:, :-1])  # odd width
    column = int(np.argmax(examples.edges[0, 80]))
    assert strength.shape == (CROP_PX, CROP_PX - 1)
    assert abs(int(np.argmax(strength[80])) - column) <= 2
    assert strength[80, column] > 5 * np.median(strength[80])


def test_a_cell_is_the_network_s_step():
    assert LAYERS[0].stride == CELL_PX
    assert LAYERS[-1].planes_out == CELL_PX**2
    assert edge_network.REACH_PX >= 32
