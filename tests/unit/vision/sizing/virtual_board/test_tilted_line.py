"""A line that rises against the boards: the bar shows by how much, and both routes measure along it."""

from dataclasses import replace

import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig
from vision.reasons import Reason
from vision.sizing.tangent.gauge import TangentGauge
from vision.sizing.virtual_board.bar_tilt import bar_tilt_deg
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

BAR = Bar(diameter_mm=180.0, offset_mm=-15.0, yaw_deg=0.6)
TILT_DEG = 4.0


@pytest.fixture(scope="module")
def pair():
    return Scene(default_rig(), seed=6).pair(BAR, 0)


@pytest.fixture(scope="module")
def rig():
    """Cameras in the frame of boards against which the line rises."""
    rig = perfect_rig(default_rig())
    turn = rig.along_line(TILT_DEG).line_axes
    left, right = (replace(camera, R=camera.R @ turn) for camera in (rig.left, rig.right))
    return replace(rig, left=left, right=right)


def measured(rig, pair):
    gauge = VirtualBoardGauge(rig, edges="sobel")
    return gauge.measure(*pair), gauge.last_pair


def test_a_rig_along_the_line_sees_the_line_as_it_is(rig):
    point = np.array([[30.0, 120.0, 50.0]])
    along = rig.along_line(TILT_DEG)
    assert along.left.project(point) == pytest.approx(perfect_rig(default_rig()).left.project(point), abs=1e-9)
    assert np.abs(along.along_line(0.0).left.R - rig.left.R).max() < 1e-12


def test_the_bar_shows_how_the_line_rises(rig, pair):
    _, aligned = measured(rig, pair)
    first_deg = bar_tilt_deg(aligned)
    assert first_deg == pytest.approx(TILT_DEG, abs=0.3)
    _, aligned = measured(rig.along_line(first_deg), pair)
    assert first_deg + bar_tilt_deg(aligned) == pytest.approx(TILT_DEG, abs=0.05)


def test_on_boards_that_are_turned_the_diameter_is_right(rig, pair):
    reading, _ = measured(rig.along_line(TILT_DEG), pair)
    assert abs(reading.diameter_mm - 180.0) <= reading.expanded_uncertainty_mm


def test_route_t_measures_along_the_line_and_refuses_a_bar_that_seems_to_float(rig, pair):
    parallel, along = (TangentGauge(one, 0.0).measure(*pair) for one in (rig, rig.along_line(TILT_DEG)))
    assert Reason.IMPLAUSIBLE in parallel.reasons
    assert abs(along.diameter_mm - 180.0) <= along.expanded_uncertainty_mm


def test_without_parallax_no_tilt_is_told(rig, pair):
    _, aligned = measured(rig, pair)
    same = replace(aligned.alignment, right=aligned.alignment.left, rig=replace(rig, right=rig.left))
    boards = replace(same.boards, right=same.boards.left)
    assert np.isnan(bar_tilt_deg(replace(aligned, alignment=replace(same, boards=boards))))
