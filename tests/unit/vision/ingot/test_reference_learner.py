"""References that learn: what a new camera costs is recovered, and wrong confirmations turn nothing."""

import cv2
import numpy as np
import pytest

from appliance.simulation.ingots.faces import LABELS, TYPICAL, face
from appliance.training.rendered_ends import random_camera, rendered_end
from vision.ingot.agreement import AGREED_FRAMES, Agreement
from vision.ingot.classifiers.similarity import Comparison, circular, similarity
from vision.ingot.classifiers.ssim import dual, single
from vision.ingot.reference_learner import ReferenceLearner
from vision.ingot.sequential_decision import IngotFollower
from vision.readings import OrientationReading


def ends(seed, count):
    """Ends of one line, as (picture, is top): the first two of them its references."""
    rng = np.random.default_rng(seed)
    camera = random_camera(rng)._replace(noise_codes=1.0, blur_px=0.6)
    kinds = [LABELS[number % 2] for number in range(count)]
    return [(rendered_end(face(TYPICAL[kind], rng), camera, rng), kind == "top") for kind in kinds]


def accuracy(references, judged):
    said = [(dual(*(similarity(image, one) for one in references)) == "top") == is_top for image, is_top in judged]
    return float(np.mean(said))


def darker_and_blurred(image):
    """The end as another camera shows it: out of focus, and with a lamp on one side."""
    lamp = np.linspace(0.45, 0.8, image.shape[1])
    return np.rint(cv2.GaussianBlur(image, (0, 0), 1.6) * lamp).astype(np.uint8)


def test_references_follow_a_new_camera():
    gained = []
    for seed in (3, 4):
        first, second = (image for image, _ in ends(seed, 2))
        seen = [(darker_and_blurred(image), is_top) for image, is_top in ends(seed, 50)[2:]]
        learner = ReferenceLearner((first, second), (first, second), "dual")
        before = accuracy(learner.current, seen[30:])
        changed = [learner.add(image, is_top=is_top) for image, is_top in seen[:30]]
        assert 0 < sum(changed) < 20
        gained.append(accuracy(learner.current, seen[30:]) - before)
    assert np.mean(gained) >= 0.15


@pytest.mark.parametrize("seed", [3, 9])
def test_where_one_threshold_tells_nothing_no_reference_makes_it_worse(seed):
    first, second = (image for image, _ in ends(seed, 2))
    seen = [(darker_and_blurred(image), is_top) for image, is_top in ends(seed, 50)[2:]]
    learner = ReferenceLearner((first, second), (first, second), "single")
    for image, is_top in seen[:30]:
        learner.add(image, is_top=is_top)
    before, after = (
        np.mean([(single(similarity(image, top)) == "top") == is_top for image, is_top in seen[30:]])
        for top in (first, learner.current[0])
    )
    assert after >= before


def with_corners(image, rng):
    """The end with other things around it."""
    inside = circular(np.full_like(image, 1)) > 0
    return np.where(inside, image, rng.integers(0, 256, image.shape)).astype(np.uint8)


def test_compared_within_the_circle_what_lies_around_an_end_teaches_nothing():
    rng, (first, second) = np.random.default_rng(0), (image for image, _ in ends(3, 2))
    seen = [(darker_and_blurred(image), is_top) for image, is_top in ends(3, 32)[2:]]
    learned = []
    for pictures in ([image for image, _ in seen], [with_corners(image, rng) for image, _ in seen]):
        learner = ReferenceLearner((first, second), (first, second), "dual", Comparison(circular=True))
        learned.append([learner.add(image, is_top=is_top) for image, (_, is_top) in zip(pictures, seen, strict=True)])
    assert any(learned[0])
    assert learned[0] == learned[1]


@pytest.mark.parametrize("seed", [0, 1])
def test_wrong_confirmations_now_and_then_make_no_end_the_reference_of_the_other_kind(seed):
    (first, _), (second, _), *seen = ends(seed, 44)
    learner = ReferenceLearner((first, second), (first, second), "relief")
    for number, (image, is_top) in enumerate(seen):
        wrong = number % 20 in {10, 13}
        changed = learner.add(image, is_top=is_top != wrong)
        assert not (changed and wrong)
    assert accuracy(learner.current, seen) >= accuracy((first, second), seen) - 0.05


def test_nothing_is_learned_before_both_kinds_were_confirmed():
    (first, _), (second, _), *seen = ends(1, 30)
    learner = ReferenceLearner((first, second), (first, second), "dual")
    assert not any(learner.add(image, is_top=True) for image, is_top in seen if is_top)


def reading(log_odds):
    return OrientationReading(
        present=True,
        orientation="top" if log_odds > 0 else "bottom",
        log_odds=log_odds,
        ssim_top=0.5,
        ssim_bottom=0.5,
        center_x=400.0,
        center_y=300.0,
        radius=40.0,
    )


@pytest.mark.parametrize(("share_of_bottoms", "confirmed"), [(0.0, True), (0.4, False)])
def test_an_ingot_is_confirmed_once_and_only_if_its_pictures_agree(share_of_bottoms, confirmed):
    follower, agreement, told = IngotFollower(), Agreement(), []
    for frame in range(3 * AGREED_FRAMES):
        seen = reading(-1.0 if (frame % 10) < 10 * share_of_bottoms and frame > 4 else 9.0)
        follower.add(frame, seen)
        told.append(agreement.add(seen, follower.current))
    assert [word for word in told if word] == (["top"] if confirmed else [])
