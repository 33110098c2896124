"""What the gauge does not model, against geometry computed another way: ellipses, bends, patches, ends, glow."""

import cv2
import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
import scipy.spatial
import scipy.stats

from appliance.simulation.bars.background import _irradiance, draw
from appliance.simulation.bars.bars import Bar, Oxide
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.bars.silhouette import Glow, silhouette
from appliance.simulation.bars.surface import with_details
from appliance.simulation.sensor import Blur
from appliance.simulation.true_rig import default_rig, random_rig

UNIFORM = Glow(limb_darkening=0.0, unevenness=0.0)
CORE_ONLY = Blur(core_px=0.7, halo_part=0.0)
UP = np.array([0.0, 0.0, 1.0])


def opencv_pixels(camera, points_mm):
    rotation = cv2.Rodrigues(camera.R)[0]
    return cv2.projectPoints(points_mm, rotation, camera.t, camera.K, camera.dist)[0][:, 0]


def limb_pixels(camera, bar):
    """Pixels on the limbs, and how far inside the bar their coverage says that they are, px."""
    rays = camera.rays(camera.pixel_grid()).astype(np.float32)
    seen = silhouette(camera.centre_mm, rays, bar, UNIFORM, CORE_ONLY)
    seen = with_details(seen, camera.centre_mm, rays, bar, CORE_ONLY)
    rows, columns = np.nonzero((seen.coverage > 0.1) & (seen.coverage < 0.9))
    pixels = np.column_stack([columns + seen.columns.start, rows + seen.rows.start]).astype(float)
    inner = ((pixels > 1) & (pixels < np.array(camera.image_size) - 2)).all(axis=1)
    return pixels[inner], CORE_ONLY.core_px * scipy.stats.norm.ppf(seen.coverage[rows, columns][inner])


def ellipse_point(bar, angle):
    """Point of the section's outline and outward normal there, (across, z) from the axis."""
    a, b = (bar.diameter_mm + bar.ovality_mm / 2) / 2, (bar.diameter_mm - bar.ovality_mm / 2) / 2
    c, s = np.cos(np.deg2rad(bar.ovality_deg)), np.sin(np.deg2rad(bar.ovality_deg))
    turn = np.array([[c, -s], [s, c]])
    return turn @ [a * np.cos(angle), b * np.sin(angle)], turn @ [np.cos(angle) / a, np.sin(angle) / b]


def tangent_points(bar, camera):
    """The two points of the section's outline at which lines through the camera touch it, found numerically."""
    to_camera = camera.centre_mm - bar.axis_point_mm
    eye = np.array([to_camera @ bar.across, to_camera[2]])

    def facing(angle):
        point, normal = ellipse_point(bar, angle)
        return normal @ (eye - point)

    angles = np.linspace(0, 2 * np.pi, 73)
    signs = np.sign([facing(angle) for angle in angles])
    roots = [
        scipy.optimize.brentq(facing, low, high, xtol=1e-13)
        for low, high, s, t in zip(angles[:-1], angles[1:], signs[:-1], signs[1:], strict=True)
        if s != t
    ]
    assert len(roots) == 2
    return [ellipse_point(bar, root)[0] for root in roots]


@pytest.mark.parametrize("seed", range(4))
def test_silhouettes_of_an_oval_bar_lie_on_the_tangents_of_its_ellipse(seed):
    rng = np.random.default_rng(seed)
    bar = Bar(rng.uniform(80, 300), 10.0, 1.0, ovality_mm=rng.uniform(2, 15), ovality_deg=rng.uniform(0, 180))
    camera = random_rig(rng).right
    pixels, inside_px = limb_pixels(camera, bar)
    along = np.arange(-900.0, 900.0)[:, None] * bar.axis_direction
    truth = []
    for across, z in tangent_points(bar, camera):
        line = opencv_pixels(camera, bar.axis_point_mm + across * bar.across + z * UP + along)
        nearest = scipy.spatial.cKDTree(line).query(pixels)[1]
        course, away = np.gradient(line, axis=0)[nearest], pixels - line[nearest]
        distance = np.abs(away[:, 0] * course[:, 1] - away[:, 1] * course[:, 0]) / np.hypot(*course.T)
        truth.append(np.where((nearest > 0) & (nearest < len(line) - 1), distance, np.nan))
    errors = np.abs(inside_px) - np.fmin(*truth)
    assert np.isfinite(errors).sum() > 500
    assert np.nanmax(np.abs(errors)) < 0.02


def test_an_oval_bar_is_as_wide_as_its_outline_and_rests_on_the_rollers():
    bar = Bar(150.0, ovality_mm=8.0, ovality_deg=30.0)
    outline = np.array([ellipse_point(bar, angle)[0] for angle in np.linspace(0, 2 * np.pi, 20001)])
    for along in np.deg2rad([0.0, 30.0, 75.0, 120.0]):
        extent = outline @ [-np.sin(along), np.cos(along)]
        assert bar.width_mm(np.array([np.cos(along), np.sin(along)])) == pytest.approx(np.ptp(extent), abs=1e-5)
    assert bar.width_mm(np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])) == pytest.approx(146.0)
    assert bar.axis_point_mm[2] + outline[:, 1].min() == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize("seed", range(3))
def test_rays_at_the_limb_of_a_bent_bar_pass_its_axis_at_the_radius(seed):
    rng = np.random.default_rng(seed)
    bar = Bar(rng.uniform(80, 300), -10.0, -1.0, camber_mm=(6.0, -4.0, 12.0)[seed])
    camera = random_rig(rng).left
    pixels, inside_px = limb_pixels(camera, bar)
    chosen = rng.choice(len(pixels), 150, replace=False)
    stations = np.arange(-1200.0, 1200.0, 0.5)[:, None]
    bend = -bar.camber_mm * (stations / 500) ** 2
    axis = bar.axis_point_mm + stations * bar.axis_direction + bend * bar.across

    def passing_mm(pixel):
        ray = camera.rays(pixel)
        away = axis - camera.centre_mm
        return np.sqrt(((away - np.outer(away @ ray, ray)) ** 2).sum(axis=1).min())

    for pixel, inside in zip(pixels[chosen], inside_px[chosen], strict=True):
        steps = [(passing_mm(pixel + step) - passing_mm(pixel - step)) / 0.5 for step in 0.25 * np.eye(2)]
        assert (bar.diameter_mm / 2 - passing_mm(pixel)) / np.hypot(*steps) == pytest.approx(inside, abs=0.02)


PATCHY = Bar(200.0, 15.0, 1.0, oxide=Oxide(seed=4, part=0.3, patch_mm=50.0, unevenness_c=0.0))


@pytest.fixture(scope="module")
def patchy_views():
    """For each camera of a rig, the red light of a patchy bar over that of a smooth one, and the camera."""
    scene = Scene(default_rig(), seed=1, blur=CORE_ONLY)
    smooth = Bar(200.0, 15.0, 1.0)
    return [(view.camera, view.light(PATCHY) / view.light(smooth)) for view in (scene.left, scene.right)]


def seen_at(views, angles, stations):
    """What both cameras see at points of the bar's side, shape (2, n), NaN where a camera does not see the point."""
    normal = np.cos(angles)[:, None] * PATCHY.across + np.sin(angles)[:, None] * UP
    points = PATCHY.axis_point_mm + PATCHY.diameter_mm / 2 * normal + stations[:, None] * PATCHY.axis_direction
    found = []
    for camera, ratio in views:
        to_camera = camera.centre_mm - points
        cosine = (normal * to_camera).sum(axis=1) / np.linalg.norm(to_camera, axis=1)
        x, y = opencv_pixels(camera, points).astype(np.float32).T
        light = cv2.remap(ratio[2], x[:, None], y[:, None], cv2.INTER_LINEAR)[:, 0]
        visible = (cosine > 0.15) & (x > 2) & (x < 797) & (y > 2) & (y < 597)
        found.append(np.where(visible, light, np.nan))
    return np.array(found)


def test_both_cameras_see_the_same_patches_on_the_bar_out_to_the_limbs(patchy_views):
    rng = np.random.default_rng(1)
    angles, stations = rng.uniform(0, np.pi, 4000), rng.uniform(-280, 280, 4000)
    left, right = seen_at(patchy_views, angles, stations)
    both = np.isfinite(left) & np.isfinite(right)
    assert both.sum() > 1500
    assert ((left < 0.7) == (right < 0.7))[both].mean() > 0.96
    shifted = seen_at(patchy_views, angles, stations + 30)[1]
    both &= np.isfinite(shifted)
    assert ((left < 0.7) == (shifted < 0.7))[both].mean() < 0.8


def test_patches_cover_their_part_and_are_as_dark_as_ninety_degrees_make_them(patchy_views):
    rng = np.random.default_rng(2)
    seen = seen_at(patchy_views, rng.uniform(0, np.pi, 6000), rng.uniform(-280, 280, 6000))
    seen = seen[np.isfinite(seen)]
    wien = np.exp(14387.77 / 0.62 * (1 / (1075 + 273.15) - 1 / (985 + 273.15)))
    assert np.median(seen[seen < 0.7]) == pytest.approx(wien, rel=0.01)
    assert np.median(seen[seen > 0.9]) == pytest.approx(1.0, abs=0.001)
    assert (seen < 0.7).mean() == pytest.approx(0.3, abs=0.08)
    assert ((seen > wien + 0.05) & (seen < 0.95)).mean() < 0.15  # hard edges


def test_scale_does_not_move_the_limbs():
    camera = default_rig().left
    rays = camera.rays(camera.pixel_grid()).astype(np.float32)
    plain = silhouette(camera.centre_mm, rays, PATCHY, UNIFORM, CORE_ONLY)
    patchy = with_details(plain, camera.centre_mm, rays, PATCHY, CORE_ONLY)
    assert np.abs(patchy.coverage - plain.coverage).max() < 1e-5


@pytest.mark.parametrize("ends", [{"head_mm": 120.0}, {"tail_mm": -80.0}, {"head_mm": 60.0, "tail_mm": -130.0}])
def test_a_bar_ends_where_its_end_circle_is_projected(ends):
    bar = Bar(140.0, 20.0, 1.2, **ends)
    for camera in default_rig().cameras:
        low, high = max(bar.tail_mm, -330.0), min(bar.head_mm, 330.0)
        turn = np.linspace(0, 2 * np.pi, 2000)[:, None]
        circle = bar.axis_point_mm + 70 * (np.cos(turn) * bar.across + np.sin(turn) * UP)
        outline = np.concatenate([opencv_pixels(camera, circle + s * bar.axis_direction) for s in (low, high)])
        hull = cv2.convexHull(outline.astype(np.float32))
        pixels, inside_px = limb_pixels(camera, bar)
        near_end = np.zeros(len(pixels), bool)
        for station in ends.values():
            middle = opencv_pixels(camera, (bar.axis_point_mm + station * bar.axis_direction)[None])
            near_end |= np.hypot(*(pixels - middle).T) < 70
        truth = [cv2.pointPolygonTest(hull, pixel.tolist(), measureDist=True) for pixel in pixels[near_end]]
        errors = inside_px[near_end] - truth
        assert len(errors) > 150
        assert np.sqrt((errors**2).mean()) < 0.06
        assert abs(errors.mean()) < 0.03


def test_a_bar_whose_end_is_out_of_sight_is_the_endless_bar():
    view = Scene(default_rig(), seed=1).left
    assert np.array_equal(view.light(Bar(140.0, head_mm=4000.0)), view.light(Bar(140.0)))
    assert np.array_equal(view.light(Bar(140.0, head_mm=-3000.0)), view.light(None))


@pytest.mark.parametrize(("x_mm", "z_mm"), [(300.0, 0.0), (150.0, -200.0), (0.0, -400.0)])
def test_the_glow_on_a_surface_is_the_integral_over_what_the_bar_subtends(x_mm, z_mm):
    bar = Bar(180.0)
    to_axis = np.array([-x_mm, 90.0 - z_mm])
    towards, half = np.arctan2(to_axis[0], to_axis[1]), np.arcsin(90.0 / np.hypot(*to_axis))
    integral = scipy.integrate.quad(lambda angle: max(np.cos(angle), 0) / 2, towards - half, towards + half)[0]
    point = np.array([[x_mm], [33.0], [z_mm]], np.float32)
    up = np.array([[0.0], [0.0], [1.0]], np.float32)
    assert _irradiance(bar, point, up)[0] == pytest.approx(integral, rel=0.03)


def test_the_line_reflects_the_bar_most_beside_it_and_in_the_bars_colour():
    view = Scene(default_rig(), seed=1).left
    bar = Bar(180.0)
    glow = draw(view.camera.centre_mm, view.rays, 1, view.blur, bar) - view.background
    assert glow.min() > -1e-6
    x, y = np.meshgrid([120.0, 180.0, 260.0, 400.0], np.linspace(-200, 200, 41))
    pixels = np.rint(view.camera.project(np.stack([x, y, np.zeros_like(x)], axis=-1))).astype(int)
    beside = glow[2][pixels[..., 1], pixels[..., 0]].mean(axis=0)
    assert np.all(np.diff(beside) < 0)
    assert 0.03 < beside[0] / bar.levels[2] < 0.3
    assert glow[1].sum() / glow[2].sum() == pytest.approx(bar.levels[1] / bar.levels[2], rel=1e-4)
