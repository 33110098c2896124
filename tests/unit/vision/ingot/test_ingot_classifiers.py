"""Likeness of an end to references: single and dual classifier, wrinkles, counted confusions."""

import math

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from skimage.metrics import structural_similarity

from appliance.cameras.recording.picture_file import read_picture
from appliance.comparison.confusion import Confusion
from appliance.ingot.reader_setup import load_view, make_reader
from appliance.ingot.settings import ComparisonSettings, IngotSettings
from vision.ingot.classifiers import wrinkles
from vision.ingot.classifiers.classifier import Face
from vision.ingot.classifiers.similarity import (
    ONES,
    Exponents,
    as_reference,
    circular,
    dissimilarity,
    similarity,
    similarity_map,
)
from vision.ingot.classifiers.ssim import DualSimilarity, SingleSimilarity, dual, single
from vision.ingot.end_finder import End
from vision.ingot.end_image import end_image
from vision.ingot.sequential_decision import IngotFollower
from vision.readings import OrientationReading

MARGIN = 5


def face(seed, mean=128, spread=40):
    smooth = gaussian_filter(np.random.default_rng(seed).standard_normal((64, 64)), 2)
    return np.clip(mean + spread * smooth / smooth.std(), 0, 255).astype(np.uint8)


def test_wrinkles_agree_in_direction_alike_whichever_way_the_face_lies():
    """A mirrored face is as coherent; stripes are wholly so and noise is hardly."""
    noise = face(3).astype(np.float32)
    stripes = np.tile(128 + 40 * np.sin(np.arange(64, dtype=np.float32)), (64, 1))
    assert wrinkles._coherence(noise.T.copy()) == pytest.approx(wrinkles._coherence(noise), rel=1e-4)
    assert wrinkles._coherence(stripes) == pytest.approx(1, abs=0.02)
    assert wrinkles._coherence(noise) < 0.8


@pytest.mark.parametrize("seed", range(6))
def test_our_own_maps_are_scikit_images_where_all_exponents_are_one(seed):
    a, b = face(seed), face(seed + 100, mean=100, spread=25)
    _, theirs = structural_similarity(
        a, b, gaussian_weights=True, sigma=1.5, data_range=255, use_sample_covariance=False, full=True
    )
    assert similarity_map(a, b, ONES) == pytest.approx(theirs, abs=1e-6)
    nearly = Exponents(1.0, 1.0, 1.0 + 1e-12)
    inside = np.maximum(theirs, 0)[MARGIN:-MARGIN, MARGIN:-MARGIN].mean()
    assert similarity(a, b, nearly) == pytest.approx(inside, abs=1e-6)


def test_equal_pictures_are_alike_by_any_exponents():
    assert similarity(face(1), face(1)) == pytest.approx(1.0)
    assert similarity(face(1), face(1), Exponents(0.5, 2.0, 1.5)) == pytest.approx(1.0)


def test_each_exponent_weighs_its_own_term():
    a = face(1, mean=150, spread=15)
    brighter = np.clip(a.astype(int) + 60, 0, 255).astype(np.uint8)
    assert similarity(a, brighter, Exponents(0, 1, 1)) == pytest.approx(1.0, abs=1e-3)
    assert similarity(a, brighter, Exponents(1, 0, 0)) < 0.97
    assert similarity(a, brighter, Exponents(3, 0, 0)) < similarity(a, brighter, Exponents(1, 0, 0))


def test_an_exponent_is_the_power_of_its_term_in_each_pixel():
    a, b = face(1), face(101, mean=100, spread=25)
    for place in range(3):
        once, thrice = (similarity_map(a, b, Exponents(*(n * (one == place) for one in range(3)))) for n in (1, 3))
        assert thrice == pytest.approx(once**3, abs=1e-9)
        assert np.abs(thrice - once).max() > 0.05


def test_a_negative_structure_counts_nothing_under_a_fractional_exponent():
    a = face(1)
    negative = (255 - a.astype(int)).astype(np.uint8)
    assert similarity_map(a, negative, ONES).min() < -0.5
    assert similarity_map(a, negative, Exponents(1, 1, 0.5)).min() == 0


def test_dissimilarity_is_eq_6_2():
    assert dissimilarity(0.8) == pytest.approx(0.25)
    assert dissimilarity(1.0) == 0
    assert dissimilarity(0.5, c0=2.0) == pytest.approx(3.0)
    assert dissimilarity(0.0) == dissimilarity(-0.2) == math.inf


def test_wrong_calls_name_the_argument():
    with pytest.raises(ValueError, match="reference"):
        similarity(face(1), face(1)[:32])
    for exponents in (Exponents(-1, 1, 1), Exponents(0, 0, 0)):
        with pytest.raises(ValueError, match="exponents"):
            similarity(face(1), face(1), exponents)
    with pytest.raises(ValueError, match="picture"):
        as_reference(np.zeros(64, np.uint8))


def test_the_end_fills_its_image():
    """A picture whose grey value is its column: the outermost columns lie half a step inside the circle."""
    picture = np.tile(np.arange(200, dtype=np.uint8), (200, 1))
    image = end_image(picture, End(100.0, 90.0, 32.0, "region"))
    assert image.shape == (64, 64)
    assert image[30] == pytest.approx(np.arange(68.5, 132), abs=0.51)
    assert end_image(picture, End(100.0, 90.0, 64.0, "region"))[30, [0, 31, 63]].tolist() == [37, 99, 163]


def test_single_and_dual_classifier_decide_as_in_the_dissertation():
    assert (single(0.76), single(0.75), single(0.5, threshold=0.4)) == ("top", "bottom", "top")
    assert (dual(0.7, 0.6), dual(0.7, 0.7), dual(0.6, 0.7)) == ("top", "top", "bottom")


def judged(kind, ssim_top, ssim_bottom=0.6, **options):
    return kind(face(1), face(2), **options).judge(Face(face(3), ssim_top, ssim_bottom))


def test_evidence_of_a_verdict_is_what_the_published_confusion_matrix_says_of_it():
    top, bottom = judged(SingleSimilarity, 0.8), judged(SingleSimilarity, 0.7)
    assert (top.orientation, bottom.orientation) == ("top", "bottom")
    assert top.log_odds == pytest.approx(math.log((475.5 / 585) / (0.5 / 746)))
    assert bottom.log_odds == pytest.approx(math.log((109.5 / 585) / (745.5 / 746)))
    assert judged(DualSimilarity, 0.7, 0.8).log_odds == pytest.approx(math.log((24.5 / 585) / (745.5 / 746)))


def test_a_top_that_63_of_64_pictures_call_a_top_raises_the_alarm_by_single_and_a_bottom_never_does():
    def decided(similarities):
        follower, decisions = IngotFollower(), []
        for frame, ssim_top in enumerate(similarities):
            verdict = judged(SingleSimilarity, ssim_top)
            place = {"center_x": 480.0, "center_y": 240.0 + frame, "radius": 40.0}
            seen = {"ssim_top": ssim_top, "ssim_bottom": 0.6, "log_odds": verdict.log_odds}
            reading = OrientationReading(present=True, orientation=verdict.orientation, **place, **seen)
            decisions += follower.add(frame, reading)
        return [one.orientation for one in decisions + follower.end()]

    assert decided([0.79] * 30 + [0.70] + [0.80] * 33) == ["top"]
    assert decided([0.70] * 64) == ["bottom"]


def test_the_threshold_of_single_is_a_setting():
    assert judged(SingleSimilarity, 0.7, threshold=0.65).orientation == "top"


def test_outside_the_circle_everything_is_black_and_inside_nothing_changes():
    cut = circular(np.full((64, 64), 200, np.uint8))
    assert (cut[0, 0], cut[0, 63], cut[63, 0], cut[32, 0], cut[0, 32]) == (0, 0, 0, 200, 200)
    assert np.count_nonzero(cut) == pytest.approx(np.pi * 32**2, rel=0.01)


def test_the_reader_compares_as_the_settings_say(recordings):
    view = load_view(recordings / "ingot_line")
    picture = read_picture(recordings / "ingot_line" / "seq01" / "000040.jpg").shown
    readings = [
        make_reader(IngotSettings(comparison=comparison), view, picture).read(picture)
        for comparison in (
            ComparisonSettings(),
            ComparisonSettings(circular=True),
            ComparisonSettings(structure=0.5),
        )
    ]
    assert all(reading.present for reading in readings)
    assert len({round(reading.ssim_top, 6) for reading in readings}) == 3


@pytest.mark.parametrize(
    ("confusion", "figures"),
    [
        (Confusion(475, 109, 0, 745), (1, 0.8134, 0.8724, 1, 0.9180)),  # table 6.2
        (Confusion(560, 24, 0, 745), (1, 0.9589, 0.9688, 1, 0.9819)),  # table 6.3
    ],
)
def test_precision_recall_and_accuracy_are_those_of_the_source(confusion, figures):
    ours = [measure(kind) for kind in ("top", "bottom") for measure in (confusion.precision, confusion.recall)]
    assert [*ours, confusion.accuracy] == pytest.approx(figures, abs=1e-4)


def test_undecided_is_neither_recalled_nor_accurate():
    confusion = Confusion.of([("top", "top"), ("top", "undecided"), ("bottom", "bottom"), ("bottom", "top")])
    assert confusion == Confusion(1, 0, 1, 1, top_undecided=1)
    assert (confusion.recall("top"), confusion.precision("top"), confusion.accuracy) == (0.5, 0.5, 0.5)
    assert math.isnan(Confusion().accuracy)
