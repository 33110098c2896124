"""Strips and places of a region have the bits of its whole picture, which OpenCV resamples in one call."""

import cv2
import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.simulation.true_rig import default_rig
from vision.geometry.turned_region import RegionSampler, resampled_region
from vision.pictures import brightest_channel


@pytest.fixture(scope="module")
def coloured():
    rng = np.random.default_rng(4)
    return cv2.GaussianBlur(rng.integers(0, 256, (600, 800, 3), np.uint8), (0, 0), 1.0)


@pytest.fixture(params=["coloured", "grey"])
def region(request, coloured):
    picture = coloured if request.param == "coloured" else np.ascontiguousarray(coloured[:, :, 2])
    return RegionSampler(perfect_rig(default_rig((800, 600))).left, (-130.0, 130.0), 0.8).turned(
        picture, 0.03, (-350.0, 420.0)
    )


def test_the_whole_is_what_opencv_resamples(region):
    whole = cv2.remap(region.raw.shown, *region.maps, cv2.INTER_LINEAR)
    assert np.array_equal(region.picture, whole)
    assert region.shape == whole.shape[:2]


@pytest.mark.parametrize("columns", [slice(0, 131), slice(301, 432), slice(7, 8)])
def test_a_strip_has_the_bits_of_the_whole(region, columns):
    assert np.array_equal(region.part(columns), region.picture[:, columns])


@pytest.mark.parametrize("count", [1, 33])
def test_places_have_the_bits_of_the_whole(region, count):
    rows, columns = region.shape
    places = np.random.default_rng(count).integers(0, columns, (rows, count))
    assert np.array_equal(region.at(places), region.picture[np.arange(rows)[:, None], places])


def test_a_resampled_picture_is_its_own_region(region):
    again = resampled_region(region.picture, region)
    assert np.array_equal(again.picture, region.picture)
    assert np.array_equal(again.part(slice(3, 90)), region.picture[:, 3:90])


def test_the_brightest_channel_is_the_largest_of_three(coloured):
    assert np.array_equal(brightest_channel(coloured), coloured.max(axis=2))
    assert np.array_equal(brightest_channel(coloured[:, :, 0]), coloured[:, :, 0])
