"""The aligned pair: where the right view lands on the left one, and route V on one picture out of two."""

import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig
from vision.alignment.view_alignment import Alignment
from vision.alignment.virtual_boards import VirtualBoards
from vision.fusion.methods import METHODS
from vision.geometry.turned_region import whole_picture
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

DIAMETER_MM = 180.0


@pytest.fixture(scope="module")
def rig():
    return perfect_rig(default_rig())


@pytest.fixture(scope="module")
def pair():
    return Scene(default_rig(), 1).pair(Bar(DIAMETER_MM), 0)


def painted(camera, height_mm, pattern):
    """What a camera sees of a pattern painted on the plane z = height."""
    width, height = camera.image_size
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).reshape(-1, 2).astype(float)
    rays = camera.rays(pixels)
    reach = (height_mm - camera.centre_mm[2]) / rays[:, 2]
    seen = pattern(camera.centre_mm + rays * reach[:, None])
    return np.where(np.isfinite(seen), seen, 0).astype(np.uint8).reshape(height, width)


def waves(points_mm):
    return 127 + 60 * np.sin(points_mm[:, 0] / 40) + 60 * np.sin(points_mm[:, 1] / 55)


@pytest.mark.parametrize("height_mm", [0.0, 137.0])
def test_a_pattern_on_the_plane_coincides_after_alignment_and_not_on_another_plane(rig, height_mm):
    pictures = (painted(camera, height_mm, waves) for camera in (rig.left, rig.right))
    left, right = map(whole_picture, (rig.left, rig.right), pictures)
    alignment = Alignment(rig, VirtualBoards.of_rig(rig), left, right, projective=True)
    rows, columns = (slice(size // 3, 2 * size // 3) for size in left.picture.shape)

    def apart(height):
        aligned = alignment.right_on_left(height).astype(float)
        return np.abs(aligned - left.picture)[rows, columns].mean()

    assert apart(height_mm) < 1.0
    assert apart(height_mm + 40.0) > 10.0


def test_what_only_the_left_camera_sees_is_the_left_picture(rig):
    pictures = np.full((600, 800), 200, dtype=np.uint8), np.full((600, 800), 30, dtype=np.uint8)
    left, right = map(whole_picture, (rig.left, rig.right), pictures)
    aligned = Alignment(rig, VirtualBoards.of_rig(rig), left, right, projective=True).right_on_left(100.0)
    assert set(np.unique(aligned)) >= {30, 200}
    assert aligned[:, 0].max() == 200
    assert np.median(aligned) == 30


@pytest.mark.parametrize("method", METHODS)
def test_route_v_measures_a_clean_bar_on_every_fused_picture_of_a_symmetric_rig(rig, pair, method):
    reading = VirtualBoardGauge(rig, edges="sobel", fusion=method).measure(*pair)
    assert reading.valid
    assert reading.diameter_mm == pytest.approx(DIAMETER_MM, abs=1.0)


def test_an_unknown_fusion_is_named(rig):
    with pytest.raises(ValueError, match="fusion: 'both' is none of none, fft, "):
        VirtualBoardGauge(rig, fusion="both")
