"""Lines that the preview draws over a picture, against the geometry of the bar."""

import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.simulation.true_rig import default_rig
from appliance.sizing.stereo.gauge import _edge_lines
from vision.readings import SizeReading


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_edges_of_a_bar_are_drawn_where_its_limbs_are_seen(side):
    true_rig = default_rig()
    reading = SizeReading(diameter_mm=180.0, expanded_uncertainty_mm=0.5, offset_mm=20.0, axis_height_mm=90.0)
    edges = _edge_lines(getattr(perfect_rig(true_rig), side), reading)
    assert [line.kind for line in edges] == ["edge", "edge"]
    camera = getattr(true_rig, side)
    normal = np.cross(camera.rays(np.array([line.points_px for line in edges])), [0.0, 1.0, 0.0])
    away_mm = (normal @ (camera.centre_mm - [20.0, 0.0, 90.0])) / np.linalg.norm(normal, axis=-1)
    assert np.sort(away_mm.mean(axis=1)) == pytest.approx([-90, 90], abs=0.01), "both sides of the bar"
    assert np.ptp(away_mm, axis=1) == pytest.approx(0, abs=0.01)


def test_without_a_value_no_edges_are_drawn():
    assert _edge_lines(perfect_rig(default_rig()).left, SizeReading()) == []
