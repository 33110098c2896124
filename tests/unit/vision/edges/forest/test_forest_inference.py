"""The forest's walk against a plain one node by node, in pictures and in parts of them."""

import threading

import cv2
import numpy as np
import pytest
from random_forests import random_forest, random_picture

from vision.edges.forest import channels
from vision.edges.forest.features import REGULAR_FEATURES, places_along
from vision.edges.forest.inference import EdgeDetector
from vision.edges.forest.model import StructuredForest

WHOLE = np.s_[:, :]


def leaves_alone(edge_places, trees=8):
    """Trees that are one leaf each, all with the same label mask."""
    return StructuredForest(
        tree_starts=np.arange(trees + 1, dtype=np.int32),
        left_children=np.zeros(trees, np.int32),
        feature_ids=np.zeros(trees, np.int32),
        thresholds=np.zeros(trees, np.float32),
        edge_starts=(len(edge_places) * np.arange(trees + 1)).astype(np.int32),
        edge_places=np.tile(np.asarray(edge_places, np.uint8), trees),
    )


def stumps(feature_id, threshold, trees=8):
    """Trees with one test each: below the threshold there are no edges, from it on the whole mask is edge."""
    return StructuredForest(
        tree_starts=3 * np.arange(trees + 1, dtype=np.int32),
        left_children=np.tile(np.array([1, 0, 0], np.int32), trees),
        feature_ids=np.tile(np.array([feature_id, 0, 0], np.int32), trees),
        thresholds=np.tile(np.array([threshold, 0, 0], np.float32), trees),
        edge_starts=np.append(0, (256 * np.arange(trees)[:, None] + [0, 0, 256]).ravel()).astype(np.int32),
        edge_places=np.tile(np.arange(256, dtype=np.uint8), trees),
    )


@pytest.fixture(scope="module")
def forest():
    return random_forest(seed=2, depth=8, patches=400)


def test_a_full_house_votes_two_and_the_border_gets_fewer():
    strength = EdgeDetector(leaves_alone(range(256))).strength(np.full((80, 100), 0.5, np.float32))
    assert strength.shape == (80, 100)
    assert (strength[20:-20, 20:-20] == 2).all()
    assert (strength[0] < 0.5).all()
    assert (strength[-1] == 0).all()


def test_one_edge_pixel_a_mask_votes_at_its_place():
    place = 16 * 3 + 10
    strength = EdgeDetector(leaves_alone([place])).strength(np.full((64, 96), 0.5, np.float32))
    votes = np.zeros((64, 96))
    i, j = np.mgrid[: places_along(64), : places_along(96)]
    votes[2 * i + 3, 2 * j + 10] = 4
    framed = np.pad(votes, 1, mode="reflect")
    smooth = sum(
        weight * framed[1 + dy : 65 + dy, 1 + dx : 97 + dx]
        for dy, dx, weight in [(dy, dx, (2 - abs(dy)) * (2 - abs(dx)) / 16) for dy in (-1, 0, 1) for dx in (-1, 0, 1)]
    )
    assert np.array_equal(strength, (smooth / 128).astype(np.float32))


def test_a_patch_is_judged_by_the_cell_that_its_test_names():
    row, column = 9, 6
    feature = 256 * 0 + 16 * column + row  # of L
    picture = np.zeros((96, 128), np.float32)
    picture[60:, :] = 1
    assert feature < REGULAR_FEATURES
    strength = EdgeDetector(stumps(feature, 0.15), threads=1).strength(picture)
    # the cell of place i covers the rows 2 (i + 9) - 8 and one more; from row 60 on it is bright: i from 25 on
    assert (strength[:49] == 0).all()
    assert strength[49, 64] > 0
    assert (strength[66:78, 20:-20] == 2).all()


@pytest.mark.parametrize("shape", [(121, 163), (480, 96), (64, 700)])
@pytest.mark.parametrize("colours", [1, 3])
def test_the_same_bits_with_any_number_of_threads(forest, shape, colours):
    picture = random_picture(*shape, seed=7, colours=colours)
    alone = EdgeDetector(forest, threads=1).strength(picture)
    assert alone.any()
    for threads in (2, 3):
        assert np.array_equal(EdgeDetector(forest, threads).strength(picture), alone)


@pytest.mark.parametrize(
    "region",
    [np.s_[30:60, :], np.s_[101:102, 7:300], np.s_[:, 200:201], np.s_[150:, 250:], np.s_[:33, :40], np.s_[77:140, 81:]],
)
def test_a_region_has_the_bits_of_the_whole(forest, region):
    picture = random_picture(201, 333, seed=8)
    for threads in (1, 2):
        detector = EdgeDetector(forest, threads)
        parts = detector.strength_in(picture, [region, np.s_[90:95, 10:90]])
        whole = detector.strength(picture)
        assert np.array_equal(parts[0], whole[region])
        assert np.array_equal(parts[1], whole[90:95, 10:90])


def test_many_rows_move_through_the_workspace_with_the_same_bits(forest, monkeypatch):
    picture = random_picture(300, 120, seed=9, colours=1)
    at_once = EdgeDetector(forest, threads=1).strength(picture)
    monkeypatch.setattr("vision.edges.forest.inference.CELLS_AT_ONCE", 0)
    assert np.array_equal(EdgeDetector(forest, threads=1).strength(picture), at_once)


@pytest.mark.parametrize(("threads", "pooled"), [(1, False), (2, True)])
def test_threads_of_its_own_work_where_more_than_one_is_allowed(forest, monkeypatch, threads, pooled):
    detector, seen, fill = EdgeDetector(forest, threads), [], EdgeDetector._fill

    def filled(self, *words):
        seen.append(threading.current_thread().name)
        return fill(self, *words)

    monkeypatch.setattr(EdgeDetector, "_fill", filled)
    detector.strength(np.zeros((400, 400), np.float32))
    assert [name.startswith("edges") for name in seen] == [pooled] * threads


def test_memory_of_an_earlier_picture_leaves_no_trace(forest):
    detector = EdgeDetector(forest, threads=1)
    picture, other = random_picture(150, 200, seed=1), random_picture(150, 200, seed=2)
    first = detector.strength(picture)
    detector.strength(other)
    assert np.array_equal(detector.strength(picture), first)


def test_grey_is_what_equal_colours_are(forest):
    grey = random_picture(200, 260, seed=4, colours=1)
    detector = EdgeDetector(forest)
    alone, repeated = detector.strength(grey), detector.strength(np.repeat(grey[:, :, None], 3, axis=2))
    assert np.corrcoef(alone.ravel(), repeated.ravel())[0, 1] > 0.99999


def test_any_number_of_trees_may_be_asked():
    forest = random_forest(seed=3, trees=7, trees_evaluated=6, depth=6, patches=300)
    picture = random_picture(90, 110, seed=5)
    assert np.array_equal(EdgeDetector(forest, 1).strength(picture), EdgeDetector(forest, 2).strength(picture))
    assert (EdgeDetector(leaves_alone(range(256), trees=1 + 4)).strength(picture)[30:50, 30:50] == 2).all()


def test_read_only_and_column_major_pictures_give_the_same_edges(forest):
    picture = random_picture(120, 90, seed=6, colours=1)
    detector = EdgeDetector(forest)
    wanted = detector.strength(picture)
    frozen = picture.copy()
    frozen.flags.writeable = False
    assert np.array_equal(detector.strength(frozen), wanted)
    assert np.array_equal(detector.strength(np.asfortranarray(picture)), wanted)


@pytest.mark.parametrize(
    ("image", "error", "said"),
    [
        (np.zeros((64, 64), np.uint8), TypeError, "uint8"),
        (np.zeros((64, 64)), TypeError, "float64"),
        ([[0.0]], TypeError, "list"),
        (np.zeros((0, 64), np.float32), ValueError, "0 rows"),
        (np.zeros((31, 64), np.float32), ValueError, "31 rows"),
        (np.zeros((64, 64, 4), np.float32), ValueError, "shape"),
        (np.zeros(64, np.float32), ValueError, "shape"),
        (np.full((64, 64), np.nan, np.float32), ValueError, "NaN"),
        (np.full((64, 64, 3), np.nan, np.float32), ValueError, "NaN"),
        (np.full((64, 64), 255, np.float32), ValueError, "0 to 1"),
        (np.full((64, 64, 3), -0.1, np.float32), ValueError, "0 to 1"),
        (np.full((64, 64), np.inf, np.float32), ValueError, "0 to 1"),
    ],
)
def test_what_is_no_picture_is_refused(forest, image, error, said):
    with pytest.raises(error, match=said):
        EdgeDetector(forest).strength(image)


def test_a_single_bad_pixel_is_found(forest):
    for colours in (1, 3):
        picture = random_picture(64, 64, colours=colours)
        picture[40, 20] = np.nan
        with pytest.raises(ValueError, match="NaN"):
            EdgeDetector(forest).strength(picture)


@pytest.mark.parametrize("region", [np.s_[10:10, :], np.s_[::2, :], np.s_[90:, :]])
def test_a_region_with_nothing_in_it_is_refused(forest, region):
    with pytest.raises(ValueError, match="regions"):
        EdgeDetector(forest).strength_in(np.zeros((64, 64), np.float32), [WHOLE, region])


def test_no_region_gives_nothing_and_no_threads_are_refused(forest):
    assert EdgeDetector(forest).strength_in(np.zeros((64, 64), np.float32), []) == []
    with pytest.raises(ValueError, match="threads"):
        EdgeDetector(forest, threads=0)


def test_the_light_smoothing_is_the_small_binomial_filter_with_reflected_borders():
    picture = random_picture(channels.RING, 23, seed=4, colours=1)
    binomial = np.array([0.25, 0.5, 0.25])
    expected = cv2.sepFilter2D(picture, -1, binomial, binomial, borderType=cv2.BORDER_REFLECT_101)
    smoothed = np.empty(23, np.float32)
    for row, wanted in enumerate(expected):
        channels._lightly_smoothed_row(picture, row, len(picture), np.full(40, np.nan, np.float32), smoothed)
        assert smoothed == pytest.approx(wanted, abs=1e-6), row
