"""Ends that are drawn for training: each size lies where the docstring says, and what is not varied stays."""

import numpy as np
import pytest
from placed_numbers import PlacedNumbers

from appliance.simulation.bars.bars import Bar, Oxide
from appliance.simulation.bars.study_scenes import set_up
from appliance.training import edge_scenes
from appliance.training.ingot_faces import SIZE, _blemishes, varied
from appliance.training.rendered_ends import FACE_CELLS, Camera, random_camera, rendered_end


@pytest.mark.parametrize(
    ("share", "chance", "times", "stray"),
    [(0.0, 0.5, 0.7, 0.0), (1.0, 0.5, 1.4, 0.04), (0.0, 0.9, 1.4, 0.0), (1.0, 0.9, 2.3, 0.04)],
)
def test_an_end_is_exposed_at_the_stated_times_of_the_cameras_peak(share, chance, times, stray):
    camera = Camera(0.5, 0.3, (1.0, 1.0, 1.0), 0.0, coarse_noise=False, quality=0, flattening=1.0)
    shown = rendered_end(np.ones((FACE_CELLS, FACE_CELLS), np.float32), camera, PlacedNumbers(share, chance))
    assert np.median(shown[24:40, 24:40]) == pytest.approx(255 * (0.3 * times + stray) ** (1 / 2.2), abs=2)


def test_cameras_are_between_the_sizes_that_are_stated():
    stated = [(0.35, 0.25, 1.0, 0.5, 0.1, 0.2, 60, 0.88), (1.4, 0.75, 1.5, 1.0, 0.6, 2.5, 95, 1.0)]
    for share, sizes in enumerate(stated):
        camera = random_camera(PlacedNumbers(share))
        found = camera.blur_px, camera.peak, *camera.gains, camera.noise_codes, camera.quality, camera.flattening
        assert found == pytest.approx(sizes)


def test_scale_is_varied_between_the_sizes_that_are_stated():
    for share, sizes in enumerate([(0.05, 15, 40, 5), (0.4, 120, 140, 30)]):
        oxide = edge_scenes._more_varied(Bar(150.0, oxide=Oxide(seed=1)), PlacedNumbers(share)).oxide
        assert (oxide.part, oxide.patch_mm, oxide.cooler_c, oxide.unevenness_c) == pytest.approx(sizes)


def test_a_face_that_is_not_varied_stays_as_it_is():
    image = np.random.default_rng(2).integers(0, 250, (SIZE, SIZE)).astype(np.uint8)
    for is_top in (True, False):
        change = varied(image, PlacedNumbers(0.0, 1.0), is_top=is_top).astype(int) - image
        assert set(np.unique(change)) <= {-1, 0}, "a code value is cut off, not rounded"


def test_the_middle_of_a_varied_bottom_is_darker_by_the_stated_depth_and_width():
    numbers = PlacedNumbers(0.5, whole=0.0)
    change = np.mean([_blemishes(numbers) for _ in range(400)], axis=0)  # mottling averages out
    across = (np.arange(SIZE) - (SIZE - 1) / 2) / (SIZE / 2)
    square = across[:, None] ** 2 + across[None, :] ** 2
    assert change == pytest.approx(-0.07 * np.exp(-square / 0.4**2), abs=0.015)


def test_crops_are_drawn_around_the_limbs_of_a_bar(monkeypatch):
    """The distance of each point's ray from the axis is the radius, to what four pixels are at the bar."""
    setup = set_up("clean", 5, (280, 210))
    drawn = []

    def places(camera, bar, limb, rng):
        drawn.append((camera, bar, limb))
        return placed(camera, bar, limb, rng)

    placed = edge_scenes._places
    monkeypatch.setattr(edge_scenes, "_places", places)
    next(edge_scenes._crops(setup, "left", np.zeros((210, 280, 3), np.uint8), np.random.default_rng(1)))
    camera, bar, limb = drawn[0]
    assert len(limb) > 40
    normal = np.cross(camera.rays(limb), bar.axis_direction)
    away_mm = camera.centre_mm - bar.axis_point_mm
    distance_mm = np.abs(normal @ away_mm) / np.linalg.norm(normal, axis=1)
    pixel_mm = np.linalg.norm(away_mm) / camera.K[0, 0]
    assert np.abs(distance_mm - bar.diameter_mm / 2).max() < 4.5 * pixel_mm
