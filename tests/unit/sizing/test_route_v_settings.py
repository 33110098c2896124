"""Edges, model and fusion of route V as settings: they reach the gauge that the appliance makes."""

import json
from dataclasses import replace

import numpy as np
import pytest
from mill_scenes import perfect_rig
from pydantic import ValidationError
from random_forests import random_forest

from appliance.black_box.black_box import BOX_FILE
from appliance.cameras.simulated.pairs import MillSource
from appliance.simulation.true_rig import default_rig
from appliance.sizing.recorded_settings import recorded_gauge, recorded_settings
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


def measured(gauge, exposed):
    """Readings of an exposure, in words: NaN equals NaN there."""
    return repr(gauge.measure_exposed(exposed)[0])


def test_the_black_box_brings_the_forest_that_its_gauge_had_and_measures_to_the_same_bits(tmp_path, rig):
    save_rig(rig, tmp_path / "rig.json")
    own, box = tmp_path / "own.npz", tmp_path / "box"
    random_forest(seed=5, depth=4, patches=200).save(own)
    settings = SizingSettings(rig=tmp_path / "rig.json", edge_model=own)
    gauge = settings.make_gauge(lambda: None)
    random_forest(seed=6, depth=4, patches=200).save(own)  # another model under its name, after the start
    files = recorded_settings(settings, gauge)
    assert sorted(files) == ["scale/edge_model.npz", "scale/rig.json", "settings.json"]
    for name, content in (*files.items(), (BOX_FILE, b'{"carried": [null, null]}')):
        (box / name).parent.mkdir(parents=True, exist_ok=True)
        (box / name).write_bytes(content)
    replaced = settings.make_gauge(lambda: None)
    own.unlink()
    again = recorded_gauge(box)[1]
    with MillSource(seed=1, rate_hz=0) as source:
        exposed = source.next(1)
    assert measured(again, exposed) == measured(gauge, exposed)
    assert measured(replaced, exposed) != measured(gauge, exposed)


def test_without_a_forest_of_its_own_a_recording_brings_none(tmp_path, rig):
    save_rig(rig, tmp_path / "rig.json")
    settings = SizingSettings(rig=tmp_path / "rig.json")
    files = recorded_settings(settings, settings.make_gauge(lambda: None))
    assert sorted(files) == ["scale/rig.json", "settings.json"]
    assert json.loads(files["settings.json"])["rig"] == "scale/rig.json"


def test_a_model_belongs_to_the_forest(tmp_path):
    with pytest.raises(ValidationError, match="edge_model: sobel has none"):
        SizingSettings(edges="sobel", edge_model=tmp_path / "own.npz")
