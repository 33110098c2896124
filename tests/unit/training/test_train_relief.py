"""The network of relief: its slopes are those of its loss, and it learns what it is shown."""

import numpy as np
import pytest

from appliance.simulation.ingots.faces import LABELS
from appliance.training.ingot_relief import first_layers, loss_and_slopes, trained
from appliance.training.rendered_ends import random_face, rendered_end
from vision.ingot.classifiers.relief import log_odds_of, relief


def test_slopes_are_those_of_the_loss():
    rng = np.random.default_rng(0)
    layers = [(weights.astype(np.float64), bias + 0.1) for weights, bias in first_layers(rng)]
    images, tops = rng.standard_normal((2, 64, 64, 2)), np.array([0.0, 1.0])
    _, slopes = loss_and_slopes(layers, images, tops)
    parameters = [one for pair in layers for one in pair]
    for one, slope in zip(parameters, slopes, strict=True):
        assert slope.shape == one.shape
        place = np.unravel_index(np.argmax(np.abs(slope)), one.shape)
        losses = []
        for step in (1e-6, -2e-6):
            one[place] += step
            losses.append(loss_and_slopes(layers, images, tops)[0])
        one[place] += 1e-6
        assert (losses[0] - losses[1]) / 2e-6 == pytest.approx(slope[place], rel=1e-2)


def test_it_learns_a_rim_of_light():
    rng = np.random.default_rng(1)
    images = 0.3 * rng.standard_normal((256, 64, 64, 2)).astype(np.float32)
    tops = np.arange(256) % 2 == 0
    images[tops, 20:24] += 1
    layers = trained(images, tops.astype(np.float32), epochs=6)
    loss, _ = loss_and_slopes(layers, images, tops.astype(np.float32))
    assert loss < 0.3


def test_the_network_that_is_shipped_tells_rendered_ends_it_has_not_seen():
    right, count = 0, 60
    for number in range(count):
        rng = np.random.default_rng([424242, number])
        label = LABELS[number % 2]
        right += (log_odds_of(rendered_end(random_face(label, rng), rng)) > 0) == (label == "top")
    assert right >= 0.8 * count


def test_exposure_changes_no_relief_and_what_is_clipped_shows_none():
    rng = np.random.default_rng(5)
    image = np.clip(rng.normal(120, 8, (64, 64)), 0, 255).astype(np.uint8)
    brighter = np.rint(1.2 * image).astype(np.uint8)
    assert relief(brighter)[..., 0] == pytest.approx(relief(image)[..., 0], abs=0.25)
    assert not relief(np.full((64, 64), 255, np.uint8)).any()
