"""The tangents' crossing: the symmetric limit of the source's correction, and the whole model back and forth."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from vision.reasons import Reason
from vision.sizing.virtual_board.gauge import VirtualBoardGauge
from vision.sizing.virtual_board.tangent_crossing import solve_section, tangent_cuts


def plane_of(cameras_mm, bar):
    """Height at which the middles of both views' outlines coincide."""
    return brentq(
        lambda height: np.subtract(*tangent_cuts(cameras_mm, bar, height).mean(axis=1)), -200, 600, xtol=1e-12
    )


@pytest.mark.parametrize(("distance_mm", "g", "R"), [(3000.0, 0.3, 100.0), (1600.0, 0.6, 140.0), (4000.0, 0.1, 45.0)])
def test_two_cameras_alike_see_2_r_cos_b_over_cos_g_on_the_plane_where_the_tangents_cross(distance_mm, g, R):
    cameras_mm = np.array([[s * distance_mm * np.sin(g), R + distance_mm * np.cos(g)] for s in (-1, 1)])
    plane_mm = plane_of(cameras_mm, np.array([0.0, R, R]))
    left, right = tangent_cuts(cameras_mm, np.array([0.0, R, R]), plane_mm)
    b = np.arcsin(R / distance_mm)
    assert right[1] - right[0] == pytest.approx(2 * R * np.cos(b) / np.cos(g), rel=1e-9)
    assert left == pytest.approx(right, abs=1e-6)
    assert np.hypot(right[1], plane_mm - R) == pytest.approx(R / np.cos(g), rel=1e-9)
    section = solve_section(cameras_mm, plane_mm, float(right[1] - right[0]), 0.0)
    assert section.radius_mm == pytest.approx(R, abs=1e-6)


@pytest.mark.parametrize("step_mm", [1.0, 0.5])
@pytest.mark.parametrize(("off_px", "doubted"), [(2.8, False), (3.2, True), (-2.8, False), (-3.2, True)])
def test_widths_that_differ_by_more_than_three_pixels_contradict_a_round_bar(step_mm, off_px, doubted):
    cameras_mm = np.array([[-900.0, 2800.0], [700.0, 2600.0]])
    bar = np.array([10.0, 80.0, 80.0])
    plane_mm = plane_of(cameras_mm, bar)
    cuts = tangent_cuts(cameras_mm, bar, plane_mm)
    width = cuts[:, 1] - cuts[:, 0]
    section = solve_section(cameras_mm, plane_mm, width.mean(), cuts.mean())
    height = SimpleNamespace(height_mm=plane_mm, quality=SimpleNamespace(percent=100.0))
    view_mm = width + np.array([off_px, -off_px]) * step_mm / 2
    gauge = SimpleNamespace(_step_mm=step_mm)
    reasons = VirtualBoardGauge._reasons_of_section(gauge, section, SimpleNamespace(height=height), view_mm, cameras_mm)
    assert reasons == (Reason.VIEWS_DISAGREE if doubted else Reason.NONE)


def test_any_rig_gives_back_the_bar_that_it_saw():
    rng = np.random.default_rng(1)
    for _ in range(200):
        cameras_mm = np.array([[s * rng.uniform(200, 1800), rng.uniform(1000, 3500)] for s in (-1, 1)])
        R = rng.uniform(40, 150)
        bar = np.array([rng.uniform(-60, 60), R + rng.uniform(0, 5), R])
        plane_mm = plane_of(cameras_mm, bar)
        cuts = tangent_cuts(cameras_mm, bar, plane_mm)
        width = cuts[:, 1] - cuts[:, 0]
        section = solve_section(cameras_mm, plane_mm, width.mean(), cuts.mean())
        assert [section.across_mm, section.height_mm, section.radius_mm] == pytest.approx(bar, abs=1e-5)
        assert section.width_mm == pytest.approx(width, abs=1e-5)
        wider = solve_section(cameras_mm, plane_mm, width.mean() + 0.1, cuts.mean())
        assert 2 * (wider.radius_mm - section.radius_mm) == pytest.approx(0.1 * section.diameter_per_width, rel=1e-3)


def test_a_bar_that_would_enclose_a_camera_has_no_section():
    assert solve_section(np.array([[-500.0, 800.0], [500.0, 800.0]]), 100.0, 5000.0, 0.0) is None
