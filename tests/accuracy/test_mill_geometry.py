"""The mill's pictures against geometry computed another way: OpenCV's lens, dense ray casting, exact calculus."""

import math

import cv2
import numpy as np
import pytest
import scipy.optimize
import scipy.spatial
import scipy.special
import scipy.stats

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.bars.silhouette import Glow, silhouette
from appliance.simulation.boards.board_pictures import board_light
from appliance.simulation.boards.boards import Board, Pose, low_pose, random_poses
from appliance.simulation.sensor import Blur
from appliance.simulation.true_rig import default_rig, random_rig

UNIFORM = Glow(limb_darkening=0.0, unevenness=0.0)
CORE_ONLY = Blur(core_px=0.7, halo_part=0.0)


def random_bar(rng):
    return Bar(rng.uniform(80, 300), rng.uniform(-50, 50), rng.uniform(-1.5, 1.5))


def opencv_pixels(camera, points_mm):
    rotation = cv2.Rodrigues(camera.R)[0]
    return cv2.projectPoints(points_mm, rotation, camera.t, camera.K, camera.dist)[0][:, 0]


def opencv_rays(camera, pixels):
    """Rays by OpenCV's own inversion of the lens, iterated until nothing moves."""
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-14)
    pinhole = cv2.undistortImagePoints(pixels[:, None], camera.K, camera.dist, arg1=criteria)[:, 0]
    directions = np.column_stack([pinhole, np.ones(len(pinhole))]) @ np.linalg.inv(camera.K).T @ camera.R
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def tangent_lines(camera, bar, along_mm):
    """Points of the two generators at which planes through the camera touch the cylinder, from school geometry."""
    u, foot = bar.axis_direction, bar.axis_point_mm
    to_camera = camera.centre_mm - foot
    to_camera = to_camera - (to_camera @ u) * u
    distance = np.linalg.norm(to_camera)
    e1 = to_camera / distance
    e2 = np.cross(u, e1)
    radius = bar.diameter_mm / 2
    half = np.arccos(radius / distance)
    for side in (-1, 1):
        touch = foot + radius * (np.cos(half) * e1 + side * np.sin(half) * e2)
        yield touch + np.outer(along_mm, u)


def distance_px(line_px, pixels):
    """Distance of pixels from a curve given by dense points, to the tangent at the nearest; NaN beyond its ends."""
    nearest = scipy.spatial.cKDTree(line_px).query(pixels)[1]
    course = np.gradient(line_px, axis=0)[nearest]
    away = pixels - line_px[nearest]
    distance = np.abs(away[:, 0] * course[:, 1] - away[:, 1] * course[:, 0]) / np.hypot(*course.T)
    return np.where((nearest > 0) & (nearest < len(line_px) - 1), distance, np.nan)


def test_projection_is_that_of_opencv():
    for seed in range(100):
        rng = np.random.default_rng(seed)
        points = rng.uniform((-230, -270, 0), (230, 270, 300), (200, 3))
        for camera in random_rig(rng).cameras:
            assert np.abs(camera.project(points) - opencv_pixels(camera, points)).max() < 1e-9


def test_rays_are_the_exact_inverse_of_the_projection_in_the_whole_picture():
    for seed in range(30):
        rng = np.random.default_rng(seed)
        for camera in random_rig(rng).cameras:
            pixels = rng.uniform((-5, -5), np.array(camera.image_size) + 4, (300, 2))
            rays = camera.rays(pixels)
            assert np.abs(camera.project(camera.centre_mm + 3000 * rays) - pixels).max() < 1e-7
            assert np.abs(rays - opencv_rays(camera, pixels)).max() < 1e-9


BAND_ROWS = 80


def test_silhouettes_lie_on_the_tangents_of_the_cylinder_over_a_hundred_random_rigs():
    rngs = [np.random.default_rng(seed) for seed in range(100)]
    errors = np.concatenate(
        [
            limb_errors_px(camera, bar, rng.integers(600 - BAND_ROWS))
            for rng in rngs
            for bar in [random_bar(rng)]
            for camera in random_rig(rng).cameras
        ]
    )
    assert len(errors) > 40000
    assert np.abs(errors).max() < 0.01
    assert abs(errors.mean()) < 0.001


def limb_errors_px(camera, bar, first_row):
    """Distance from the limb that the coverage of pixels says, minus the true one, in a band of rows."""
    rays = camera.rays(camera.pixel_grid()[first_row : first_row + BAND_ROWS]).astype(np.float32)
    seen = silhouette(camera.centre_mm, rays, bar, UNIFORM, CORE_ONLY)
    if seen is None:
        return np.array([])
    rows, columns = np.nonzero((seen.coverage > 0.1) & (seen.coverage < 0.9))
    in_band = np.column_stack([columns + seen.columns.start, rows + seen.rows.start])
    lines = [opencv_pixels(camera, line) for line in tangent_lines(camera, bar, np.arange(-900.0, 900))]
    truth = np.fmin(*(distance_px(line, in_band + np.array([0, first_row])) for line in lines))
    drawn = CORE_ONLY.core_px * np.abs(scipy.stats.norm.ppf(seen.coverage[rows, columns]))
    inner = ((in_band > 0) & (in_band < [camera.image_size[0] - 1, BAND_ROWS - 1])).all(axis=1)
    return (drawn - truth)[inner & np.isfinite(truth)]


@pytest.mark.parametrize("seed", range(4))
def test_every_pixel_near_a_limb_is_what_dense_ray_casting_through_the_blur_gives(seed):
    rng = np.random.default_rng(seed)
    bar, camera = random_bar(rng), random_rig(rng).left
    rays = camera.rays(camera.pixel_grid()).astype(np.float32)
    glow = Glow(limb_darkening=0.3, unevenness=0.2)
    seen = silhouette(camera.centre_mm, rays, bar, glow, CORE_ONLY)
    cut = (seen.coverage > 0.02) & (seen.coverage < 0.98)
    cut[:6], cut[-6:], cut[:, :6], cut[:, -6:] = False, False, False, False
    rows, columns = np.nonzero(cut)
    chosen = rng.choice(len(rows), 25, replace=False)
    steps = (np.arange(161) - 80) * 0.05
    taps = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    weights = np.exp(-(taps**2).sum(axis=1) / (2 * CORE_ONLY.core_px**2))
    for row, column in zip(rows[chosen], columns[chosen], strict=True):
        pixel = np.array([column + seen.columns.start, row + seen.rows.start], dtype=float)
        hit, light = cast(camera, bar, glow, opencv_rays(camera, pixel + taps))
        assert seen.coverage[row, column] == pytest.approx(np.average(hit, weights=weights), abs=0.004)
        assert seen.glow[row, column] == pytest.approx(np.average(light, weights=weights), abs=0.004)


def cast(camera, bar, glow, rays):
    """Whether rays hit the cylinder and the light they meet there, from the quadratic equation of the hit."""
    u, centre, radius = bar.axis_direction, camera.centre_mm - bar.axis_point_mm, bar.diameter_mm / 2
    across_ray = rays - np.outer(rays @ u, u)
    across_centre = centre - (centre @ u) * u
    a = (across_ray**2).sum(axis=1)
    b = across_ray @ across_centre
    discriminant = b**2 - a * (across_centre @ across_centre - radius**2)
    hit = discriminant > 0
    depth = (-b - np.sqrt(np.where(hit, discriminant, 0))) / a
    normal = (across_centre + across_ray * depth[:, None]) / radius
    cos_exit = np.clip(-(normal * across_ray).sum(axis=1) / np.sqrt(a), 0, 1)
    place = np.arctan2(normal[:, 2], normal @ np.cross(u, [0, 0, 1]))
    warm = 1 + glow.unevenness * np.cos(place - np.deg2rad(bar.warm_side_deg))
    return hit, hit * warm * (1 - glow.limb_darkening * (1 - cos_exit))


def test_the_halo_carries_its_part_of_the_light_away_from_the_limb():
    camera, bar = default_rig().left, Bar(200.0)
    rays = camera.rays(camera.pixel_grid()).astype(np.float32)
    seen = silhouette(camera.centre_mm, rays, bar, UNIFORM, Blur(core_px=0.7, halo_px=5.0, halo_part=0.1))
    row = seen.coverage[300 - seen.rows.start]
    inside = np.flatnonzero(row > 0.5)
    tangent = next(iter(tangent_lines(camera, bar, np.linspace(-300, 300, 60001))))
    pixels = opencv_pixels(camera, tangent)
    limb = pixels[np.argmin(np.abs(pixels[:, 1] - 300))]
    course = pixels[1] - pixels[0]
    obliqueness = abs(course[1]) / np.hypot(*course)
    edge = min((inside[0], inside[-1]), key=lambda column: abs(column + seen.columns.start - limb[0]))
    outwards = -1 if edge == inside[0] else 1
    column = edge + 6 * outwards
    outside_px = abs(column + seen.columns.start - limb[0]) * obliqueness
    gaussian_tail = 0.5 * (1 - math.erf(outside_px / (5.0 * math.sqrt(2))))
    assert row[column] == pytest.approx(0.1 * gaussian_tail, rel=0.05)


@pytest.fixture(scope="module")
def scene():
    return Scene(default_rig(), seed=5)


def test_corners_of_rendered_boards_lie_where_opencv_projects_them():
    errors = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        rig, board = random_rig(rng), Board(square_error_mm=0.4)
        scene = Scene(rig, seed)
        for pose in random_poses(rig, rng, board, 1):
            for view in (scene.left, scene.right):
                light = board_light(view, board, pose)
                truth = opencv_pixels(view.camera, world_corners(pose, 50.4))
                errors += [fitted_corner(light, corner) - corner for corner in truth[rng.permutation(28)[:6]]]
    errors = np.array(errors)
    assert len(errors) == 4 * 2 * 6
    assert np.abs(errors).max() < 0.02
    assert np.abs(errors.mean(axis=0)).max() < 0.003


def fitted_corner(light, near):
    """Where two blurred straight edges cross, by least squares over the light around a corner."""
    radius = 5
    column, row = np.rint(near).astype(int)
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    patch = light[row - radius : row + radius + 1, column - radius : column + radius + 1]

    def model(p):
        first, second = (scipy.special.erf(((x - p[0]) * np.cos(a) + (y - p[1]) * np.sin(a)) / p[4]) for a in p[2:4])
        return p[5] + p[6] * x + p[7] * y + (p[8] + p[9] * x + p[10] * y) * first * second

    def fit(turn):
        start = [*(near - [column, row]), turn, turn + np.pi / 2, 1.0, patch.mean(), 0, 0, np.ptp(patch) / 2, 0, 0]
        return scipy.optimize.least_squares(lambda p: (model(p) - patch).ravel(), start, max_nfev=40)

    best = min((fit(turn) for turn in (0.0, np.pi / 4, np.pi / 2, 3 * np.pi / 4)), key=lambda result: result.cost)
    return best.x[:2] + np.array([column, row])


def world_corners(pose: Pose, square_mm):
    """Inner corners of an 8 x 5 board, row by row along the long side, first at -x +y."""
    return np.array(
        [
            pose.centre_mm + square_mm * ((column - 3) * pose.axes[0] + (1.5 - row) * pose.axes[1])
            for row in range(4)
            for column in range(7)
        ]
    )


def test_the_first_square_of_a_rendered_board_is_black_and_its_neighbours_are_white(scene):
    board, view = Board(), scene.left
    light = board_light(view, board, low_pose(board))
    first = np.array([[-175.0, 100.0, 0.0], [-125.0, 100.0, 0.0], [-175.0, 50.0, 0.0], [175.0, -100.0, 0.0]])
    columns, rows = np.rint(opencv_pixels(view.camera, first)).astype(int).T
    is_white = light[rows, columns] > 0.2
    assert is_white.tolist() == [False, True, True, True]


def test_the_default_rig_resolves_like_a_real_one():
    for camera in default_rig().cameras:
        pair = np.array([[0.0, 0.0, 100.0], [10.0, 0.0, 100.0]])
        first, second = opencv_pixels(camera, pair)
        assert 1.3 < 10 / np.hypot(*(second - first)) < 2.5
        assert 2500 < np.linalg.norm(camera.centre_mm) < 3500
