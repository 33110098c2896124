"""The figures of merit against independent implementations, hand-computed cases and their own ranges."""

import cv2
import numpy as np
import pytest
from skimage.measure import shannon_entropy
from skimage.metrics import normalized_mutual_information

from vision.fusion import metrics
from vision.fusion.methods import fuse
from vision.fusion.metrics import METRICS


def noise(seed=0, shape=(60, 83)):
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


def scene(seed):
    blurred = cv2.GaussianBlur(noise(seed, (96, 128)), None, 2.0)
    return cv2.normalize(blurred, None, 20, 230, cv2.NORM_MINMAX)


def test_entropy_agrees_with_skimage_and_knows_its_ends():
    for picture in (noise(), scene(1), noise() // 64):
        assert metrics.entropy(picture) == pytest.approx(shannon_entropy(picture, base=2), abs=1e-9)
    assert metrics.entropy(np.full((5, 7), 9, dtype=np.uint8)) == 0.0
    assert metrics.entropy(np.arange(256, dtype=np.uint8).reshape(16, 16)) == pytest.approx(8.0)


def test_standard_deviation_agrees_with_numpy_and_knows_its_ends():
    assert metrics.standard_deviation(noise()) == pytest.approx(np.std(noise().astype(float)), rel=1e-12)
    halves = np.repeat(np.array([[0, 255]], dtype=np.uint8), 8, axis=0)
    assert metrics.standard_deviation(halves) == 127.5


def test_spatial_frequency_of_a_hand_computed_case():
    picture = np.array([[0, 3, 3], [4, 3, 0]], dtype=np.uint8)
    within_rows, within_columns = 3**2 + 0 + 1 + 3**2, 4**2 + 0 + 3**2
    assert metrics.spatial_frequency(picture) == pytest.approx(np.sqrt((within_rows + within_columns) / 6))


def test_the_printed_forms_are_those_of_the_equations():
    left, right = scene(1), scene(2)
    fused = fuse(left, right, "db4")
    a, b, f = (picture.astype(float) for picture in (left, right, fused))
    scd = np.corrcoef((f - a).ravel(), a.ravel())[0, 1] + np.corrcoef((f - b).ravel(), b.ravel())[0, 1]
    assert metrics.printed_sum_of_correlations(fused, left, right) == pytest.approx(scd)
    assert metrics.printed_edge_dissimilarity(left, left, left) == pytest.approx(0, abs=1e-6)
    essim = 1000 * metrics.edge_dissimilarity(fused, left, right)
    assert metrics.printed_edge_dissimilarity(fused, left, right) == pytest.approx(essim)
    own = metrics.printed_feature_mutual_information(left, left, left)  # I(A, A) = H(A), twice
    assert own == pytest.approx(2 * metrics.entropy(metrics._gradient_steps(left).reshape(left.shape).astype(np.uint8)))


def test_average_gradient_of_a_hand_computed_case():
    picture = np.array([[0, 3, 3], [4, 3, 0]], dtype=np.uint8)
    assert metrics.average_gradient(picture) == pytest.approx((5 + 0) / 2 / np.sqrt(2))
    slope = np.add.outer(3 * np.arange(9), 4 * np.arange(9)).astype(np.uint8)
    assert metrics.average_gradient(slope) == pytest.approx(5 / np.sqrt(2))
    assert np.isnan(metrics.average_gradient(picture[:1]))


def test_feature_mutual_information_agrees_with_skimage():
    left, right = scene(1), scene(2)
    fused = fuse(left, right, "db4")

    def feature(picture):
        x, y = (cv2.Sobel(picture, cv2.CV_64F, *order, borderType=cv2.BORDER_REPLICATE) for order in ((1, 0), (0, 1)))
        return np.rint(np.hypot(x, y) / (4 * np.sqrt(2)))

    def shared(a, b):  # skimage's is (H_a + H_b) / H_ab
        edges = int(max(a.max(), b.max())) + 1
        a, b = (np.concatenate([one.ravel(), [0, edges - 1]]) for one in (a, b))
        return 1 - 1 / normalized_mutual_information(a, b, bins=edges)

    features = [feature(picture) for picture in (fused, left, right)]
    expected = shared(features[0], features[1]) + shared(features[0], features[2])
    assert metrics.feature_mutual_information(fused, left, right) == pytest.approx(expected, abs=2e-3)


def test_feature_mutual_information_knows_its_ends():
    same, flat = scene(1), np.full((96, 128), 7, dtype=np.uint8)
    assert metrics.feature_mutual_information(same, same, same) == pytest.approx(1.0)
    assert metrics.feature_mutual_information(same, flat, flat) == pytest.approx(0.0)
    assert metrics.feature_mutual_information(flat, flat, flat) == 1.0


def test_the_sum_of_correlations_of_differences_agrees_with_numpy():
    left, right = scene(1), scene(2)
    fused = fuse(left, right, "fft")
    f, a, b = (picture.astype(float).ravel() for picture in (fused, left, right))
    expected = np.corrcoef(f - b, a)[0, 1] + np.corrcoef(f - a, b)[0, 1]
    assert metrics.sum_of_correlations_of_differences(fused, left, right) == pytest.approx(expected, rel=1e-9)


def test_the_sum_of_correlations_of_differences_knows_its_ends():
    left, right = scene(1) // 2, scene(2) // 2
    assert metrics.sum_of_correlations_of_differences(left + right, left, right) == pytest.approx(2.0)
    assert metrics.sum_of_correlations_of_differences(left, left, left) == 0.0


def essim_by_loops(first, second):
    total = []
    gradient = [
        [cv2.Sobel(p, cv2.CV_64F, *order, borderType=cv2.BORDER_REPLICATE) for order in ((1, 0), (0, 1))]
        for p in (first, second)
    ]
    for top in range(0, first.shape[0] - 15, 16):
        for at in range(0, first.shape[1] - 15, 16):
            here = slice(top, top + 16), slice(at, at + 16)
            x, y = first[here].astype(float), second[here].astype(float)
            histogram = np.zeros((2, 8))
            for row, (gx, gy) in zip(histogram, gradient, strict=True):
                for u, v in zip(gx[here].ravel(), gy[here].ravel(), strict=True):
                    angle = np.degrees(np.arctan2(v, u)) % 180
                    row[int(angle // 22.5) % 8] += np.hypot(u, v) / 256
            luminance = (2 * x.mean() * y.mean() + 6.5025) / (x.mean() ** 2 + y.mean() ** 2 + 6.5025)
            contrast = (2 * x.std() * y.std() + 58.5225) / (x.var() + y.var() + 58.5225)
            covariance = np.cov(histogram, bias=True)[0, 1]
            edges = (covariance + 29.26125) / (histogram[0].std() * histogram[1].std() + 29.26125)
            total.append(luminance * contrast * edges)
    return np.mean(total)


def test_edge_similarity_agrees_with_its_definition_written_as_loops():
    first, second = scene(1)[:70, :90], scene(2)[:70, :90]
    assert metrics.essim(first, second) == pytest.approx(essim_by_loops(first, second), abs=1e-6)


def test_edge_dissimilarity_knows_its_ends_and_grows_with_blur():
    sharp = scene(1)
    assert metrics.edge_dissimilarity(sharp, sharp, sharp) == pytest.approx(0.0, abs=1e-9)
    blurred = [cv2.GaussianBlur(sharp, None, sigma) for sigma in (1.0, 2.0, 4.0)]
    values = [metrics.edge_dissimilarity(picture, sharp, sharp) for picture in blurred]
    assert 0 < values[0] < values[1] < values[2] <= 2
    assert np.isfinite(metrics.essim(noise(0, (3, 3)), noise(1, (3, 3))))


def test_the_table_measures_every_row_and_finds_a_fused_picture_closer_than_a_strange_one():
    left, right = scene(1), cv2.GaussianBlur(scene(1), None, 1.5)
    for row in METRICS:
        fused, strange = (row.measure(picture, left, right) for picture in (fuse(left, right, "fft"), scene(7)))
        assert np.isfinite([fused, strange]).all()
        if row.of_fused:
            assert (fused > strange) == row.larger_is_better


@pytest.mark.parametrize("row", METRICS, ids=lambda row: row.symbol)
def test_pictures_without_these_figures_are_refused(row):
    floats = np.zeros((20, 20), dtype=np.float32)
    with pytest.raises(ValueError, match="grey uint8 picture is needed, not float32"):
        row.measure(floats, floats, floats)
    if row.of_fused:
        with pytest.raises(ValueError, match="alike in shape"):
            row.measure(noise(), noise()[:-1], noise())


def test_mutual_information_counts_both_views_alike():
    seen = np.random.default_rng(8).integers(0, 255, (64, 64), np.uint8)
    flat = np.full((64, 64), 90, np.uint8)
    # alone I(F, F) / 2 H(F) = 1/2; a flat view has nothing in common with anything
    assert metrics.feature_mutual_information(seen, seen, flat) == pytest.approx(0.5, abs=1e-9)
    assert metrics.feature_mutual_information(seen, flat, seen) == pytest.approx(0.5, abs=1e-9)
    printed = metrics.printed_feature_mutual_information
    assert (
        printed(seen, seen, flat)
        == pytest.approx(printed(seen, flat, seen))
        == pytest.approx(printed(seen, seen, seen) / 2)
    )
