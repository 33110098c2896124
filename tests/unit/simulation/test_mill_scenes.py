"""Scenes for studies: each switch changes what its name says and nothing else."""

import cv2
import numpy as np
import pytest

from appliance.simulation.bars.bars import Bar, levels
from appliance.simulation.bars.disturbances import Glare, Haze, Post, Shimmer
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.bars.real_line import several_bars
from appliance.simulation.bars.silhouette import axis_distance
from appliance.simulation.bars.study_scenes import CONDITIONS, draw, set_up
from appliance.simulation.sensor import Sensor, coded
from appliance.simulation.true_rig import default_rig, nudged

SIZE = (240, 180)
NAMES = [row.name for row in CONDITIONS if row.kind == "condition"]
EFFECTS = [row.name for row in CONDITIONS if row.kind == "effect"]
CHANGES = [*((name, ()) for name in NAMES if name != "clean"), *(("clean", (name,)) for name in EFFECTS)]
DECODE = {
    "srgb": lambda v: np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4),
    "linear": lambda v: v,
    "gamma 2.2": lambda v: v**2.2,
}


def pictures(scene):
    return np.stack([scene.left, scene.right]).astype(float)


def beside_bar_mm(scene_setup, side):
    """Distance of each pixel's ray from the bar's surface, negative on the bar."""
    camera, bar = getattr(scene_setup.rig, side), scene_setup.bars[0]
    rays = camera.rays(camera.pixel_grid()).astype(np.float32)
    return np.abs(axis_distance(camera.centre_mm, rays, bar)) - bar.diameter_mm / 2


@pytest.mark.parametrize(("name", "effects"), [("clean", ()), *CHANGES])
def test_a_seed_gives_the_same_scene_every_time_and_another_seed_another(name, effects):
    first, again, other = (draw(name, seed, SIZE, effects) for seed in (7, 7, 8))
    assert np.array_equal(pictures(first), pictures(again))
    assert first.truth == again.truth
    assert not np.array_equal(pictures(first), pictures(other))


@pytest.mark.parametrize(
    ("name", "effects"), [*((name, ()) for name in NAMES[1:]), *(("clean", (e,)) for e in EFFECTS)]
)
def test_each_switch_changes_the_pictures_but_neither_rig_nor_response(name, effects):
    clean, changed = draw("clean", 7, SIZE), draw(name, 7, SIZE, effects)
    assert not np.array_equal(pictures(clean), pictures(changed))
    assert clean.response == changed.response
    for camera, same in zip(clean.rig.cameras, changed.rig.cameras, strict=True):
        assert all(np.array_equal(getattr(camera, name), getattr(same, name)) for name in ("K", "dist", "R", "t"))


@pytest.mark.parametrize(("condition", "effects"), [("dusty", ()), ("clean", ("scale",)), ("ovality", ())])
def test_a_name_that_is_not_in_the_table_is_a_wrong_call(condition, effects):
    with pytest.raises(ValueError, match="is not a"):
        draw(condition, 1, SIZE, effects)


def test_names_in_the_table_are_unique():
    assert len({row.name for row in CONDITIONS}) == len(CONDITIONS)


@pytest.mark.parametrize("name", NAMES)
def test_there_is_a_diameter_exactly_when_one_bar_can_be_measured(name):
    for seed in range(20):
        setup = set_up(name, seed)
        if name in ("two-bars", "no-bar", "one-blind"):
            assert setup.diameter_mm is None
        elif name == "bar-end":
            bar, (low, high) = setup.bars[0], setup.rig.region_y_mm
            covered = bar.head_mm - low if np.isfinite(bar.head_mm) else high - bar.tail_mm
            assert (setup.diameter_mm is None) == (covered < (high - low) / 2)
        else:
            assert setup.diameter_mm == pytest.approx(setup.bars[0].diameter_mm)


@pytest.mark.parametrize(("name", "effects"), [("post", ()), ("glare", ()), ("one-blind", ()), ("clean", ("nudged",))])
def test_what_concerns_one_camera_leaves_the_other_as_it_is(name, effects):
    for seed in (1, 2):
        clean, changed = draw("clean", seed, SIZE), draw(name, seed, SIZE, effects)
        same = [np.array_equal(getattr(clean, side), getattr(changed, side)) for side in ("left", "right")]
        assert sum(same) == 1


def test_scale_darkens_the_bar_and_leaves_its_surroundings_alone():
    setup = set_up("scale", 3, SIZE)
    clean, scaled = draw("clean", 3, SIZE), draw("scale", 3, SIZE)
    beside_mm = beside_bar_mm(setup, "left")
    difference = np.abs(scaled.left.astype(float) - clean.left)[..., 2]
    assert difference[beside_mm < 0].max() > 30
    assert difference[beside_mm > 150].max() <= 2  # what the halo carries


def test_without_a_bar_nothing_glows_and_two_bars_are_two():
    for seed in range(3):
        assert draw("no-bar", seed, SIZE).left[..., 2].max() < draw("clean", seed, SIZE).left[..., 2].max() - 30
        bars = set_up("two-bars", seed).bars
        assert bars[1].offset_mm - bars[0].offset_mm > (bars[0].diameter_mm + bars[1].diameter_mm) / 2
        assert all(abs(bar.offset_mm) + bar.diameter_mm / 2 < 300 for bar in bars)


def test_overexposure_clips_red_and_scales_what_is_not_clipped():
    clean, bright = draw("clean", 5, SIZE), draw("overexposed", 5, SIZE)
    gain = set_up("overexposed", 5, SIZE).gain
    assert (bright.left[..., 2] == 255).mean() > 0.05
    decode = DECODE[clean.response]
    blue = [decode(scene.left[..., 0] / 255.0) for scene in (clean, bright)]
    free = bright.left[..., 0] < 250
    assert blue[1][free].mean() / blue[0][free].mean() == pytest.approx(gain, rel=0.05)


def test_every_channel_keeps_some_limb_when_overexposed():
    gains = [set_up("overexposed", seed).gain for seed in range(40)]
    red, blue = (levels(1075.0)[channel] for channel in (2, 0))
    assert all(gain * red > 1 for gain in gains)
    assert all(gain * blue < 0.6 for gain in gains)


def test_a_bounce_moves_the_bar_for_the_right_camera_only():
    still, bounced = draw("clean", 4, SIZE), draw("clean", 4, SIZE, ["bounce"])
    assert np.array_equal(still.left, bounced.left)
    assert not np.array_equal(still.right, bounced.right)


def test_a_nudged_camera_turns_about_its_own_centre():
    camera = default_rig().left
    turned = nudged(camera, (0.03, -0.1, 0.2))
    assert turned.centre_mm == pytest.approx(camera.centre_mm, abs=1e-9)
    expected = cv2.Rodrigues(np.deg2rad([0.03, -0.1, 0.2]))[0]
    assert pytest.approx(expected, abs=1e-12) == turned.R @ camera.R.T
    turns = [np.linalg.norm(*set_up("clean", seed, effects=["nudged"]).nudges.values()) for seed in range(50)]
    assert 0.02 <= min(turns) < 0.04
    assert 0.18 < max(turns) <= 0.2


def test_bars_and_lenses_of_studies_differ_as_real_ones_do():
    setups = [set_up("clean", seed) for seed in range(200)]
    darkening = [setup.glow.limb_darkening for setup in setups]
    assert min(darkening) < 0.005
    assert 0.055 < max(darkening) <= 0.06
    assert {setup.sensor.response for setup in setups} == {"srgb", "linear", "gamma 2.2"}
    regions = np.array([setup.rig.region_y_mm for setup in setups])
    assert np.abs(regions).min() >= 150
    assert np.abs(regions).max() <= 250
    assert np.ptp(regions, axis=0).min() > 90


@pytest.fixture(scope="module")
def view():
    return Scene(default_rig(), seed=2).left


def test_a_post_hides_what_is_behind_it_between_its_tangents(view):
    foot, radius_mm = (-300.0, -800.0), 40.0
    coverage = Post("left", foot, radius_mm, 0.0, soft_px=1.0).coverage(view)
    centre = view.camera.centre_mm
    away = np.array(foot) - centre[:2]
    distance = np.hypot(*away)
    half = np.arcsin(radius_mm / distance)
    for turn, expected in ((0.0, 1.0), (half, 0.5), (-half, 0.5), (1.5 * half, 0.0)):
        c, s = np.cos(turn), np.sin(turn)
        direction = np.array([[c, -s], [s, c]]) @ away / distance
        points = np.column_stack([np.tile(centre[:2] + distance * direction, (30, 1)), np.linspace(800, 1700, 30)])
        pixels = view.camera.project(points)
        inside = ((pixels > 1) & (pixels < [798, 598])).all(axis=1)
        assert inside.sum() > 5
        seen = cv2.remap(coverage, *pixels[inside].astype(np.float32).T[..., None], cv2.INTER_LINEAR)
        assert seen == pytest.approx(expected, abs=0.02)


def test_haze_takes_contrast_and_adds_a_smooth_veil(view):
    haze = Haze("left", seed=1, density=0.3)
    black, white = (haze.changed(np.full((3, 600, 800), level, np.float32), view, 0) for level in (0.0, 1.0))
    assert (white - black).mean() == pytest.approx(0.7, abs=0.1)
    assert black[2].min() > 0
    steps = np.abs(np.diff(black[2], axis=1))
    assert steps.max() < 0.02 * black[2].mean()


def test_glare_adds_light_within_its_radius_only(view):
    light = np.full((3, 600, 800), 0.1, np.float32)
    lit = Glare("left", (300.0, 200.0), 20.0, 4.0, 0.5).changed(light, view, 0)
    row = lit[0, 200]
    assert row[300] == pytest.approx(0.6, abs=1e-3)
    assert row[320] == pytest.approx(0.35, abs=1e-3)
    assert row[340] == pytest.approx(0.1, abs=1e-3)


def test_hot_air_moves_pixels_by_the_stated_tenths_near_the_bar_anew_in_each_frame(view):
    bar = Bar(150.0)
    shimmer = Shimmer("left", 3, bar, 0.3)
    moves = np.stack([shimmer.displacement_px(view, frame) for frame in range(8)])
    rays = view.rays
    beside_mm = np.abs(axis_distance(view.camera.centre_mm, rays, bar)) - 75
    assert moves[..., beside_mm < 0].std() == pytest.approx(0.3, rel=0.1)
    assert np.abs(moves[..., beside_mm > 250]).max() < 0.001
    assert abs(np.corrcoef(moves[0].ravel(), moves[1].ravel())[0, 1]) < 0.3
    assert np.abs(np.diff(moves, axis=-1)).max() < 0.3  # smooth: no pixel tears from its neighbour


def test_displaced_light_comes_from_where_the_field_says(view):
    ramp = np.broadcast_to(np.arange(800, dtype=np.float32) / 800, (3, 600, 800)).copy()
    shimmer = Shimmer("left", 3, Bar(150.0), 0.3)
    moved = shimmer.changed(ramp.copy(), view, 1)
    expected = ramp[0] + shimmer.displacement_px(view, 1)[0] / 800
    assert np.abs(moved[0] - expected)[5:-5, 5:-5].max() < 1e-4


@pytest.mark.parametrize("level", [0.02, 0.3, 0.8])
def test_noise_of_an_exposed_picture_follows_its_level(level):
    sensor = Sensor("linear", 4000, 15)
    flat = Scene(default_rig(SIZE), seed=1, sensor=sensor).left
    light = np.full((3, SIZE[1], SIZE[0]), level, np.float32)
    values = flat.exposed(light, 5).astype(float) / 255
    assert values.std() == pytest.approx(np.sqrt(level / 4000 + (15 / 4000) ** 2 + 1 / (12 * 255**2)), rel=0.03)
    assert values.mean() == pytest.approx(level, abs=3e-4)


def test_full_colour_jpeg_keeps_red_edges_and_halved_colour_blurs_them():
    picture = np.zeros((64, 64, 3), np.uint8)
    picture[:, 33:] = (60, 130, 210)
    assert coded(picture, "lossless") is picture
    errors = [
        np.abs(coded(picture, coding).astype(float) - picture)[:, 30:36].max()
        for coding in ("jpeg 4:4:4", "jpeg 4:2:0")
    ]
    assert errors[0] < 12
    assert errors[1] > 2 * errors[0]


def test_out_of_focus_pictures_have_a_wider_core():
    assert set_up("clean", 3).blur.core_px < 1.05
    assert 1.2 <= set_up("clean", 3, effects=["defocus"]).blur.core_px <= 2.2


@pytest.mark.parametrize("count", [2, 3, 5])
def test_bars_side_by_side_fit_between_the_barriers_with_gaps_as_told(count):
    for seed in range(20):
        bars = several_bars(seed, count).setup.bars
        reach_mm = [bar.diameter_mm / 2 for bar in bars]
        edges_mm = np.array([(bar.offset_mm - r, bar.offset_mm + r) for bar, r in zip(bars, reach_mm, strict=True)])
        gaps_mm = edges_mm[1:, 0] - edges_mm[:-1, 1]
        assert len(bars) == count
        assert ((gaps_mm >= 25) & (gaps_mm <= 50)).all()
        assert max(bar.diameter_mm for bar in bars) <= 120
        assert edges_mm[-1, 1] - edges_mm[0, 0] <= 420
        assert edges_mm[0, 0] == pytest.approx(-edges_mm[-1, 1]), "in the middle of the line"
