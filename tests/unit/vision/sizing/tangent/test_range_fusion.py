"""A laser's point beside the limbs: exact by geometry, weighted by the least variance, never a silent mean."""

from types import SimpleNamespace

import numpy as np
import pytest
from mill_scenes import perfect_rig
from tangent_rays import CAMERAS, RADIUS, TRUTH, X0, Z0, tangent_rays

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.laser import Laser
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig
from vision.geometry.surface_point import SurfacePoint
from vision.reasons import Reason
from vision.sizing.gauge import Gauge
from vision.sizing.tangent import range_fusion
from vision.sizing.tangent.bent_cylinder import UNSEEN_BOW, BentCylinder
from vision.sizing.tangent.cylinder_fit import fit_cylinder
from vision.sizing.tangent.section import SectionView
from vision.sizing.tangent.tangent_planes import TangentPlane
from vision.sizing.tangent.uncertainty_budget import Circumstances

DOWN = np.array([0.0, 0.0, -1.0])
U_MM = 0.2


def point_at(turn_deg, *, out_mm=0.0, y_mm=30.0):
    """A point of the cylinder at an angle from z towards x, met by a beam from above."""
    turn = np.deg2rad(turn_deg)
    normal = np.array([np.sin(turn), 0.0, np.cos(turn)])
    return SurfacePoint(np.array([X0, y_mm, Z0]) + (RADIUS + out_mm) * normal, DOWN, U_MM)


@pytest.mark.parametrize("turn_deg", [-30.0, 0.0, 12.0])
def test_the_gap_of_a_point_and_its_slopes(turn_deg):
    point = point_at(turn_deg, out_mm=0.7)
    gap_mm, slope, _ = range_fusion.surface_gap(TRUTH, point)
    assert gap_mm == pytest.approx(0.7, abs=1e-9)
    step = np.diag([1e-3, 1e-3, 1e-6, 1e-6, 1e-3])
    for number, change in enumerate(step):
        up, down = (range_fusion.surface_gap(TRUTH + sign * change, point)[0] for sign in (1, -1))
        assert slope[number] == pytest.approx((up - down) / (2 * change.sum()), abs=1e-5)


@pytest.mark.parametrize("view", [0, 1])
@pytest.mark.parametrize("turn_deg", [-25.0, 0.0, 15.0])
def test_one_view_and_a_point_are_a_cylinder(view, turn_deg):
    planes = [TangentPlane.touching(CAMERAS[view], TRUTH, side) for side in (-1, 1)]
    assert range_fusion.cylinder_of_one_view(planes, point_at(turn_deg)) == pytest.approx(TRUTH, abs=1e-6)


def test_a_beam_that_passes_the_bar_makes_no_cylinder():
    planes = [TangentPlane.touching(CAMERAS[0], TRUTH, side) for side in (-1, 1)]
    aside = SurfacePoint(np.array([X0 + 2 * RADIUS, 0.0, 0.0]), DOWN, U_MM)
    assert range_fusion.cylinder_of_one_view(planes, aside) is None


def test_the_fit_of_one_view_follows_its_edges_and_the_point():
    rng = np.random.default_rng(1)
    rays = tangent_rays(rng, 0.05, limbs=(0, 1))
    planes = [TangentPlane.touching(CAMERAS[0], TRUTH, side) for side in (-1, 1)]
    points = [point_at(5.0, out_mm=out_mm) for out_mm in (0.0, 0.5)]
    starts = [range_fusion.cylinder_of_one_view(planes, point) for point in points]
    (fit, shift), (moved, _) = map(range_fusion.fit_with_point, (rays, rays), starts, points)
    assert fit.diameter_mm == pytest.approx(2 * RADIUS, abs=0.1)
    assert (moved.parameters - fit.parameters)[[0, 1, 4]] == pytest.approx(0.5 * shift[[0, 1, 4]], rel=0.05, abs=1e-3)
    assert abs(shift[4]) > 0.02  # a point that is nearer makes a smaller bar


def two_views(monkeypatch, covariance, point, *, ovality_mm=0.0):
    """Combine the exact cylinder with a point; the views' covariance is given."""
    rays = tangent_rays()
    fit = fit_cylinder(rays, TRUTH)
    section = SectionView(0.5, 0.0, np.zeros(5))
    monkeypatch.setattr(range_fusion, "section_view", lambda *_: section)
    monkeypatch.setattr(range_fusion, "parameter_covariance", lambda *_: covariance)
    known = Circumstances(ovality_mm, synchronous=True, point=point)
    points = SimpleNamespace(limb=rays.limb)
    return fit, range_fusion.of_two_views(BentCylinder(fit, rays, UNSEEN_BOW), points, None, [], known)


def test_both_heights_are_averaged_by_their_inverse_variances(monkeypatch):
    covariance = np.diag([0.0, 0.3**2, 0.0, 0.0, 0.0])  # the views know all but the height
    fit, found = two_views(monkeypatch, covariance, point_at(0.0, out_mm=0.5))
    weight = 0.3**2 / (0.3**2 + U_MM**2)
    assert found.fit.parameters[1] - fit.parameters[1] == pytest.approx(0.5 * weight, abs=1e-6)
    assert found.agrees


def test_the_combination_is_that_of_generalised_least_squares(monkeypatch):
    rng = np.random.default_rng(2)
    root = rng.normal(size=(5, 5)) * np.array([0.1, 0.3, 1e-4, 1e-4, 0.1])[:, None]
    covariance, point = root @ root.T, point_at(8.0, out_mm=0.1)
    fit, found = two_views(monkeypatch, covariance, point)
    gap_mm, slope, _ = range_fusion.surface_gap(fit.parameters, point)
    inverse = np.linalg.inv(covariance)
    step = np.linalg.solve(inverse + np.outer(slope, slope) / U_MM**2, -slope * gap_mm / U_MM**2)
    assert found.fit.parameters - fit.parameters == pytest.approx(step, rel=1e-6)


@pytest.mark.parametrize(("out_mm", "agrees"), [(0.70, True), (-0.70, True), (0.74, False), (-0.74, False)])
def test_a_point_beyond_the_uncertainty_of_both_changes_nothing(monkeypatch, out_mm, agrees):
    covariance = np.diag([0.0, 0.3**2, 0.0, 0.0, 0.0])  # 2 sqrt(0.3^2 + 0.2^2) = 0.72
    fit, found = two_views(monkeypatch, covariance, point_at(0.0, out_mm=out_mm))
    assert found.agrees == agrees
    assert (found.fit.parameters[1] != fit.parameters[1]) == agrees
    assert found.gap_mm == pytest.approx(out_mm, abs=1e-6)


def test_an_oval_bar_may_lie_nearer_to_the_laser(monkeypatch):
    covariance, point = np.diag([0.0, 0.3**2, 0.0, 0.0, 0.0]), point_at(0.0, out_mm=1.0)
    assert not two_views(monkeypatch, covariance, point)[1].agrees
    assert two_views(monkeypatch, covariance, point, ovality_mm=3.0)[1].agrees


def test_a_beam_beside_the_bar_is_not_used(monkeypatch):
    aside = SurfacePoint(np.array([X0 + 0.8 * RADIUS, 0.0, 0.0]), DOWN, U_MM)
    fit, found = two_views(monkeypatch, np.eye(5), aside)
    assert found.fit is fit
    assert np.isnan(found.gap_mm)


BAR = Bar(diameter_mm=150.0, offset_mm=12.0, yaw_deg=0.7)
LASER = Laser(np.array([0.0, 20.0, 2200.0]), DOWN)


@pytest.fixture(scope="module")
def pair():
    return Scene(default_rig(), seed=4).pair(BAR, 0)


@pytest.fixture(scope="module")
def gauge():
    return Gauge(perfect_rig(default_rig()), 0.0)


def spot(off_mm=0.0):
    return SurfacePoint.at(LASER.origin_mm, LASER.direction, LASER.true_range_mm(BAR) + off_mm, 0.3)


@pytest.mark.parametrize("shown", [0, 1])
def test_one_camera_and_a_laser_measure_the_bar(gauge, pair, shown):
    dark = np.zeros_like(pair[0])
    views = [picture if view == shown else dark for view, picture in enumerate(pair)]
    assert gauge.measure_bars(*views)[0].reasons == Reason.ONE_CAMERA
    (reading,) = gauge.measure_bars(*views, point=spot())
    assert reading.valid
    assert reading.method == "range"
    assert Reason.LIMB_HIDDEN in reading.reasons
    assert abs(reading.diameter_mm - 150.0) <= reading.expanded_uncertainty_mm < 0.4
    assert reading.u_range_mm > 0


def test_with_one_camera_a_wrong_range_widens_the_uncertainty_or_has_no_value(gauge, pair):
    dark = np.zeros_like(pair[0])
    (reading,) = gauge.measure_bars(pair[0], dark, point=spot(off_mm=-5.0))
    assert abs(reading.diameter_mm - 150.0) <= reading.expanded_uncertainty_mm
    (reading,) = gauge.measure_bars(pair[0], dark, point=spot(off_mm=-150.0))
    assert not reading.valid


def test_a_laser_that_contradicts_both_cameras_takes_trust_and_leaves_the_value(gauge, pair):
    (alone,), (beside,), (wrong,) = (gauge.measure_bars(*pair, point=point) for point in (None, spot(), spot(15.0)))
    assert beside.reasons == alone.reasons
    assert abs(beside.range_gap_mm) < 1.0
    assert wrong.diameter_mm == alone.diameter_mm
    assert wrong.reasons == alone.reasons | Reason.ROUTES_DISAGREE
    assert wrong.trust_limit == 50.0


def test_with_a_short_baseline_the_laser_narrows_the_uncertainty(monkeypatch):
    wide = np.diag([0.01, 1.5, 0.0, 0.0, 0.0]) ** 2
    wide[1, 4] = wide[4, 1] = -0.05 * 1.5**2  # the nearer, the smaller
    wide[4, 4] = (0.05 * 1.5) ** 2 + 0.01**2
    fit, found = two_views(monkeypatch, wide, point_at(0.0))
    change = found.fit.gain @ np.linalg.pinv(fit.gain)
    assert (change @ wide @ change.T)[4, 4] < 0.1 * wide[4, 4]
