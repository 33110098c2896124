"""Rays that are tangent by the geometry of a point and a circle, not by the code's own formula."""

import numpy as np
import pytest

from vision.sizing.cylinder import EdgeRays, fit_cylinder, linear_start, tangent_distance_mm

CAMERAS = np.array([[-700.0, -900.0, 2400.0], [800.0, -1100.0, 2200.0]])
X0, Z0, RADIUS = 35.0, 120.0, 110.0
FOCAL_PX = 2200.0
TRUTH = np.array([X0, Z0, 0.0, 0.0, RADIUS])


def tangent_rays(rng=None, noise_px=0.0, limbs=(0, 1, 2, 3), points=60):
    """Rays from both cameras that graze a cylinder along y; noise turns them across the bar."""
    parts = []
    for limb in limbs:
        camera, side = CAMERAS[limb // 2], (-1.0, 1.0)[limb % 2]
        to_axis = np.array([X0 - camera[0], Z0 - camera[2]])
        distance = np.hypot(*to_axis)
        y = np.linspace(-250, 250, points)
        angle = np.arctan2(to_axis[0], -to_axis[1]) + side * np.arcsin(RADIUS / distance)
        length = np.sqrt(distance**2 - RADIUS**2)
        touch = np.column_stack(
            [camera[0] + length * np.sin(angle) + 0 * y, y, camera[2] - length * np.cos(angle) + 0 * y]
        )
        if rng is not None:
            away = np.linalg.norm(touch - camera, axis=1)
            across = np.array([np.cos(angle), 0.0, np.sin(angle)])
            touch = touch + np.outer(rng.normal(0, noise_px, points) * away / FOCAL_PX, across)
        direction = touch - camera
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        window = np.arange(points) // 4
        parts.append(
            (
                np.tile(camera, (points, 1)),
                direction,
                np.full(points, side),
                np.full(points, FOCAL_PX),
                np.full(points, limb),
                window,
            )
        )
    return EdgeRays(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def test_tangent_rays_have_no_gap():
    gap, _ = tangent_distance_mm(TRUTH, tangent_rays())
    np.testing.assert_allclose(gap, 0.0, atol=1e-9)


def test_derivatives_are_those_of_the_gap():
    rays = tangent_rays()
    at = TRUTH + np.array([3.0, -2.0, 0.01, -0.02, 4.0])
    _, jacobian = tangent_distance_mm(at, rays)
    for index, step in enumerate([1e-3, 1e-3, 1e-6, 1e-6, 1e-3]):
        change = np.zeros(5)
        change[index] = step
        slope = (tangent_distance_mm(at + change, rays)[0] - tangent_distance_mm(at - change, rays)[0]) / (2 * step)
        np.testing.assert_allclose(jacobian[:, index], slope, rtol=1e-5, atol=1e-5)


def test_four_planes_give_the_cylinder():
    np.testing.assert_allclose(linear_start(tangent_rays()), TRUTH, atol=1e-6)


def test_four_limbs_give_the_cylinder():
    fit = fit_cylinder(tangent_rays())
    np.testing.assert_allclose(fit.parameters, TRUTH, atol=1e-6)
    assert fit.diameter_mm == pytest.approx(2 * RADIUS, abs=1e-6)


@pytest.mark.parametrize("hidden", range(4))
def test_three_limbs_suffice(hidden):
    limbs = [limb for limb in range(4) if limb != hidden]
    np.testing.assert_allclose(fit_cylinder(tangent_rays(limbs=limbs)).parameters, TRUTH, atol=1e-5)


def test_one_view_alone_fixes_no_cylinder():
    fit = fit_cylinder(tangent_rays(limbs=(0, 1)))
    assert fit is None or fit.u_diameter_mm > 10


def test_patches_along_one_limb_do_not_move_the_diameter():
    rng = np.random.default_rng(5)
    rays = tangent_rays(rng, 0.05)
    direction = rays.direction.copy()
    spoilt = (rays.limb == 1) & (rays.window < 5)  # a third of one limb, 4 px inwards
    direction[spoilt, 0] -= 4.0 / FOCAL_PX
    fit = fit_cylinder(EdgeRays(rays.origin_mm, direction, rays.side, rays.pixel_per_radian, rays.limb, rays.window))
    assert fit.diameter_mm == pytest.approx(2 * RADIUS, abs=0.1)
    assert np.all(fit.weight[spoilt] == 0)


def test_the_stated_scatter_is_the_scatter_over_many_noises():
    fits = [fit_cylinder(tangent_rays(np.random.default_rng(seed), 0.1)) for seed in range(300)]
    error = np.array([fit.diameter_mm for fit in fits]) - 2 * RADIUS
    stated = np.sqrt(np.mean([fit.u_diameter_mm**2 for fit in fits]))
    assert abs(error.mean()) < 4 * error.std() / np.sqrt(error.size)
    assert error.std() == pytest.approx(stated, rel=0.15)
