"""Edges, model and fusion of route V as settings: they reach the gauge that the appliance makes."""

from dataclasses import replace

import numpy as np
import pytest
from mill_scenes import perfect_rig
from pydantic import ValidationError
from random_forests import random_forest

from appliance.simulation.true_rig import default_rig
from appliance.sizing.stereo.edge_model import EdgeModelError
from appliance.sizing.stereo.gauge import RouteV, pair_gauge, rig_file_gauge
from appliance.sizing.stereo.rig_file import save_rig
from appliance.sizing.stereo.settings import SizingSettings


@pytest.fixture
def rig():
    """The mill's rig, with a world frame and without registration pictures."""
    names = ("left_low", "right_low", "left_high", "right_high")
    return replace(perfect_rig(default_rig()), boards={name: np.empty((0, 2)) for name in names})


def route_v(gauge):
    return gauge._gauge._virtual_board


def test_the_appliance_s_gauge_takes_edges_and_fusion_of_the_settings(tmp_path, rig):
    made = route_v(pair_gauge(rig, "mill", 0.0, RouteV("canny", None, "db4")))
    assert (made._edges.method, made._fusion) == ("canny", "db4")
    save_rig(rig, tmp_path / "rig.json")
    settings = SizingSettings(rig=tmp_path / "rig.json", edges="sobel", fusion="fk4")
    made = route_v(settings.make_gauge(lambda: None))
    assert (made._edges.method, made._fusion) == ("sobel", "fk4")


def test_a_trained_forest_is_used_and_a_damaged_one_is_named(tmp_path, rig):
    save_rig(rig, tmp_path / "rig.json")
    forest = random_forest(seed=5, depth=4, patches=200)
    forest.save(tmp_path / "own.npz")
    made = route_v(rig_file_gauge(tmp_path / "rig.json", 0.0, RouteV("forest", tmp_path / "own.npz")))
    assert made._edges.forest.trees == forest.trees
    (tmp_path / "own.npz").write_bytes(b"nothing")
    with pytest.raises(EdgeModelError, match="train-edges"):
        rig_file_gauge(tmp_path / "rig.json", 0.0, RouteV("forest", tmp_path / "own.npz"))
    check = SizingSettings(rig=tmp_path / "rig.json", edge_model=tmp_path / "own.npz").check_scale()
    assert check.verdict == "BAD"
    assert "own.npz" in check.text


def test_a_model_belongs_to_the_forest(tmp_path):
    with pytest.raises(ValidationError, match="edge_model: sobel has none"):
        SizingSettings(edges="sobel", edge_model=tmp_path / "own.npz")
