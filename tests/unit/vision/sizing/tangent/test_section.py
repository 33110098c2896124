"""Sections that are not round, bars that are bent and views that moved, from tangents computed on their own."""

import numpy as np
import pytest

from vision.sizing.tangent.bent_cylinder import Bow, fit_bent_cylinder
from vision.sizing.tangent.cylinder_fit import EdgeRays
from vision.sizing.tangent.edge_points import EdgePoints
from vision.sizing.tangent.section import section_view

CAMERAS = np.array([[-760.0, -1600.0, 2400.0], [760.0, -1700.0, 2350.0]])
RADIUS, X0, Z0 = 80.0, 12.0, 80.0
FOCAL_PX = 2000.0
START = np.array([X0 + 1, Z0 - 1, 0.001, 0.0, RADIUS + 0.5])


def edges(support=lambda _: RADIUS, bow_per_mm=0.0, right_aside_mm=0.0, noise_px=0.0):
    """Points and rays that touch a bar whose support function is given, with a bowed axis; y along the line."""
    rng = np.random.default_rng(0)
    parts = []
    for limb in range(4):
        view, side = limb // 2, (-1.0, 1.0)[limb % 2]
        camera, y = CAMERAS[view], np.linspace(-250, 250, 300)
        aside = np.array([right_aside_mm if view else 0.0, 0.0])
        middle = np.array([X0, Z0]) + aside
        eye = camera[[0, 2]]
        turn = np.arctan2(*(eye - middle)[::-1]) - side * np.pi / 2
        for _ in range(30):  # the tangent through the eye: n . (eye - middle) = h(n)
            distance = np.hypot(*(eye - middle))
            turn = np.arctan2(*(eye - middle)[::-1]) - side * np.arccos(support(turn) / distance)
        normal, along = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
        reach = (eye - middle) @ along
        touch = middle + support(turn) * normal + 0.0 * along
        point = np.column_stack([touch[0] + bow_per_mm * y**2 / 2, y, np.full(len(y), touch[1])])
        depth = np.hypot(reach, 1700.0)
        point += np.outer(rng.normal(0, noise_px * depth / FOCAL_PX, len(y)), [normal[0], 0.0, normal[1]])
        direction = point - camera
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        window = ((y + 250) // 20).astype(np.int64).clip(0, 24)
        parts.append(
            (
                np.tile(camera, (300, 1)),
                direction,
                np.full(300, side),
                np.full(300, limb),
                window,
                y,
                np.full(300, view),
            )
        )
    origin, direction, side, limb, window, y, view = (np.concatenate(column) for column in zip(*parts, strict=True))
    one = np.ones(len(side))
    points = EdgePoints(np.zeros((len(side), 2)), view, side, limb, y, window, one)
    return points, EdgeRays(origin, direction, side, FOCAL_PX * one, limb, window, one)


def fitted(**bar):
    points, rays = edges(**bar)
    bent = fit_bent_cylinder(points, rays, START, 250.0)
    return bent, section_view(bent.fit, points, bent.rays)


def oval(ovality_mm, along_deg):
    return lambda turn: RADIUS + ovality_mm / 4 * np.cos(2 * (turn - np.deg2rad(along_deg)))


@pytest.mark.parametrize("along_deg", range(0, 180, 15))
def test_no_section_moves_the_diameter_by_more_than_what_the_views_cannot_see(along_deg):
    bent, view = fitted(support=oval(1.0, along_deg))
    assert abs(bent.fit.diameter_mm - 2 * RADIUS) <= 0.5 * view.unseen_share * 1.02 + 0.002
    assert 0.5 < view.unseen_share <= 1.0


def test_the_largest_error_over_all_directions_is_that_share():
    errors, shares = zip(
        *(
            (fit.fit.diameter_mm - 2 * RADIUS, view.unseen_share)
            for fit, view in (fitted(support=oval(1.0, along)) for along in range(0, 180, 5))
        ),
        strict=True,
    )
    assert max(np.abs(errors)) == pytest.approx(0.5 * np.mean(shares), rel=0.05)


def test_the_views_see_a_part_of_the_ovality_and_never_more_than_there_is():
    seen = [fitted(support=oval(1.0, along), noise_px=0.05)[1].seen_ovality_mm for along in range(0, 180, 5)]
    assert max(seen) == pytest.approx(1.0, rel=0.15)
    assert min(seen) < 0.3


def test_noise_shows_little_ovality():
    assert fitted(noise_px=0.1)[1].seen_ovality_mm < 0.1


@pytest.mark.parametrize("aside_mm", [-1.0, 0.5, 2.0])
def test_the_height_tells_how_far_a_view_that_moved_aside_moves_the_diameter(aside_mm):
    bent, view = fitted(right_aside_mm=aside_mm)
    height_mm = bent.fit.parameters[1] - bent.fit.parameters[4]
    error_mm = bent.fit.diameter_mm - 2 * RADIUS
    assert abs(error_mm) > 0.01
    assert abs(2 * view.sideways[4] * height_mm) == pytest.approx(abs(error_mm), rel=0.25)


@pytest.mark.parametrize("bow_per_mm", [-2e-5, 8e-6, 5e-5])
def test_a_bowed_axis_is_measured_and_leaves_the_diameter_alone(bow_per_mm):
    bent, _ = fitted(bow_per_mm=bow_per_mm, noise_px=0.1)
    assert abs(bent.bow.per_mm - bow_per_mm) < 4 * bent.bow.u_per_mm < 3e-6
    assert bent.fit.diameter_mm == pytest.approx(2 * RADIUS, abs=0.02)


def test_a_bow_is_one_from_four_uncertainties_and_a_twentieth_of_a_millimetre_on():
    """Over 250 mm to either side, 3.2e-6 per mm is 0.1 mm."""
    assert Bow(4.5e-6, 1e-6).clear(250.0)
    assert not Bow(3.5e-6, 1e-6).clear(250.0)
    assert Bow(1.7e-6, 1e-9).clear(250.0)
    assert not Bow(1.5e-6, 1e-9).clear(250.0)


def test_a_straight_axis_has_no_bow_beyond_its_noise():
    bent, _ = fitted(noise_px=0.1)
    assert abs(bent.bow.per_mm) < 4 * bent.bow.u_per_mm
