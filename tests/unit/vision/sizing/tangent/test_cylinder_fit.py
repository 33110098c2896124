"""The cylinder that rays touch, against rays whose cylinder is known."""

from dataclasses import replace

import numpy as np
import pytest
from tangent_rays import CAMERAS, FOCAL_PX, RADIUS, START, TRUTH, X0, Z0, tangent_rays

from vision.geometry.consensus_line import consensus_line
from vision.sizing.tangent import cylinder_steps
from vision.sizing.tangent.cylinder_fit import fit_cylinder, tangent_distance_mm, touched_points
from vision.sizing.tangent.tangent_planes import TangentPlane, rough_cylinder


def test_tangent_rays_have_no_gap():
    gap, _ = tangent_distance_mm(TRUTH, tangent_rays())
    np.testing.assert_allclose(gap, 0.0, atol=1e-9)


@pytest.mark.parametrize(("windows", "known"), [(1, False), (2, True)])
def test_rays_of_a_single_window_say_nothing_of_their_scatter(windows, known):
    rays = tangent_rays(np.random.default_rng(4), noise_px=0.1)
    fit = fit_cylinder(replace(rays, window=rays.window * windows // (rays.window.max() + 1)), START)
    assert fit is not None
    assert np.isfinite(fit.u_diameter_mm) == known


def test_the_narrowest_scale_of_the_weights_is_the_noise_of_neighbours():
    residual_px = np.random.default_rng(5).normal(0, 0.4, 4000)
    near = np.arange(4000) < 4000 - cylinder_steps.LAG_POINTS
    assert cylinder_steps._narrowed_px(residual_px, near, 30, np.empty(4000)) == pytest.approx(0.4, rel=0.08)


def test_derivatives_are_those_of_the_gap():
    rays = tangent_rays()
    at = TRUTH + np.array([3.0, -2.0, 0.01, -0.02, 4.0])
    _, jacobian = tangent_distance_mm(at, rays)
    for index, step in enumerate([1e-3, 1e-3, 1e-6, 1e-6, 1e-3]):
        change = np.zeros(5)
        change[index] = step
        slope = (tangent_distance_mm(at + change, rays)[0] - tangent_distance_mm(at - change, rays)[0]) / (2 * step)
        np.testing.assert_allclose(jacobian[:, index], slope, rtol=1e-5, atol=1e-5)


def planes(limbs=(0, 1, 2, 3)):
    return [TangentPlane.touching(CAMERAS[limb // 2], TRUTH, (-1, 1)[limb % 2]) for limb in limbs]


@pytest.mark.parametrize("limbs", [(0, 1, 2, 3), (0, 1, 2), (1, 2, 3)])
def test_three_or_four_planes_give_the_cylinder(limbs):
    np.testing.assert_allclose(rough_cylinder(planes(limbs)), TRUTH, atol=1e-6)


def test_two_tangent_planes_give_no_cylinder():
    assert rough_cylinder(planes((0, 1))) is None


def test_a_plane_is_the_one_through_its_own_line_and_is_touched_where_its_rays_touch():
    rays = tangent_rays()
    for limb, plane in enumerate(planes()):
        again = TangentPlane.through(plane.centre_mm, plane.line, plane.side)
        np.testing.assert_allclose(again.normal, plane.normal, atol=1e-9)
        mine = rays.limb == limb
        np.testing.assert_allclose(rays.direction[mine] @ plane.normal, 0.0, atol=1e-9)
        places_mm = plane.places_mm(TRUTH, np.linspace(-250, 250, 60))
        np.testing.assert_allclose(plane.stations_mm(TRUTH, places_mm), np.linspace(-250, 250, 60), atol=1e-6)
        touched_mm, outwards = touched_points(TRUTH, rays)
        np.testing.assert_allclose(touched_mm[mine][:, 1], np.linspace(-250, 250, 60), atol=1e-6)
        np.testing.assert_allclose(np.hypot(*(touched_mm - [X0, 0, Z0])[:, [0, 2]].T), RADIUS, atol=1e-6)
        np.testing.assert_allclose(outwards[:, 1], 0.0, atol=1e-9)


def test_a_line_is_found_among_more_points_that_lie_elsewhere():
    rng = np.random.default_rng(1)
    y = np.linspace(-250, 250, 100)
    x = 0.01 * y + 5 + rng.normal(0, 0.1, 100)
    x[20:80] += rng.uniform(5, 30, 60)
    line, agrees = consensus_line(y, x, 1.0)
    np.testing.assert_allclose(line * [250, 1], [2.5, 5.0], atol=0.1)
    assert np.count_nonzero(agrees) == 40


def test_four_limbs_give_the_cylinder():
    fit = fit_cylinder(tangent_rays(), START)
    np.testing.assert_allclose(fit.parameters, TRUTH, atol=1e-6)
    assert fit.diameter_mm == pytest.approx(2 * RADIUS, abs=1e-6)


@pytest.mark.parametrize("hidden", range(4))
def test_three_limbs_suffice(hidden):
    limbs = [limb for limb in range(4) if limb != hidden]
    np.testing.assert_allclose(fit_cylinder(tangent_rays(limbs=limbs), START).parameters, TRUTH, atol=1e-5)


def test_one_view_alone_fixes_no_cylinder():
    fit = fit_cylinder(tangent_rays(limbs=(0, 1)), START)
    assert fit is None or fit.u_diameter_mm > 10


def test_patches_along_one_limb_do_not_move_the_diameter():
    rng = np.random.default_rng(5)
    rays = tangent_rays(rng, 0.05)
    direction = rays.direction.copy()
    spoilt = (rays.limb == 1) & (rays.window < 5)  # a third of one limb, 4 px inwards
    direction[spoilt, 0] -= 4.0 / FOCAL_PX
    fit = fit_cylinder(replace(rays, direction=direction), START)
    assert fit.diameter_mm == pytest.approx(2 * RADIUS, abs=0.1)
    assert np.all(fit.weight[spoilt] == 0)


def test_the_stated_scatter_is_the_scatter_over_many_noises():
    fits = [fit_cylinder(tangent_rays(np.random.default_rng(seed), 0.1), START) for seed in range(300)]
    error = np.array([fit.diameter_mm for fit in fits]) - 2 * RADIUS
    stated = np.sqrt(np.mean([fit.u_diameter_mm**2 for fit in fits]))
    assert abs(error.mean()) < 4 * error.std() / np.sqrt(error.size)
    assert error.std() == pytest.approx(stated, rel=0.15)
