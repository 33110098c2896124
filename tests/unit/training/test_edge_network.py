"""The edge network: its slopes are those of its loss, it learns a step, and OpenCV runs what was trained."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from edge_network_on_opencv import EdgeNetwork

from appliance.training import edge_network
from appliance.training.edge_network import (
    CELL_PX,
    LAYERS,
    Examples,
    first_weights,
    loss_and_slopes,
    network_input,
    outlines,
)
from appliance.training.edge_scenes import CROP_PX

MODEL = Path(__file__).parents[2] / "studies" / "edge_network.onnx"


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


def test_it_learns_a_step(monkeypatch):
    monkeypatch.setattr(edge_network, "EXAMPLES_A_BATCH", 1)
    monkeypatch.setattr(edge_network, "WARM_STEPS", 5)
    rng = np.random.default_rng(1)
    weights, examples = first_weights(rng), steps(rng, 2)
    before, _ = loss_and_slopes(weights, examples)
    edge_network.train(weights, examples, 20, rng)
    assert loss_and_slopes(weights, examples)[0] < 0.5 * before


def test_opencv_runs_what_was_trained(tmp_path):
    rng = np.random.default_rng(2)
    weights, batch = first_weights(rng), steps(rng, 1)
    edge_network.write(weights, tmp_path / "edges.onnx")
    net = cv2.dnn.readNetFromONNX(str(tmp_path / "edges.onnx"))
    net.setInput(np.ascontiguousarray(network_input(batch.images.astype(np.float32)).transpose(0, 3, 1, 2)))
    strength, edges = net.forward()[0, 0].astype(np.float64), batch.edges[0]
    entropy = -np.mean(np.where(edges, np.log(strength), np.log1p(-strength)))
    assert entropy == pytest.approx(loss_and_slopes(weights, batch)[0], rel=1e-4)


def test_the_stored_network_sees_a_step_where_it_is_in_pictures_of_any_size():
    examples = steps(np.random.default_rng(3), 1)
    image = examples.images[0].astype(np.float32)[:, :-1]
    strength = EdgeNetwork(MODEL).strength(image)
    column = int(np.argmax(examples.edges[0, 80]))
    assert strength.shape == image.shape[:2]
    assert abs(int(np.argmax(strength[80])) - column) <= 1
    grey, three = image[..., 0], np.repeat(image[..., :1], 3, axis=2)
    assert EdgeNetwork(MODEL).strength(grey) == pytest.approx(EdgeNetwork(MODEL).strength(three), abs=1e-6)


def test_a_cell_is_the_network_s_step():
    assert LAYERS[0].stride == CELL_PX
    assert LAYERS[-1].planes_out == CELL_PX**2
    assert edge_network.REACH_PX >= 32
