"""References that learn, over 50 weeks: focus, exposure and a lamp drift, and the camera is exchanged once.

As commissioned (none), learned from ingots whose pictures agree (agreement), from an operator's word (operator), and
from an operator who is wrong once in 20 times (operator_5_percent_wrong).
"""

import statistics

import cv2
import numpy as np

from appliance.simulation.ingots.cast_faces import cast_face
from appliance.simulation.ingots.faces import LABELS, TYPICAL, face
from appliance.simulation.ingots.foreign_faces import foreign_face
from appliance.training.rendered_ends import random_camera, rendered_end
from vision.ingot.face_judge import FaceJudge
from vision.ingot.reference_learner import ReferenceLearner

TEXT = (
    "Fifty weeks of a line: each week an ingot of either kind, two pictures of each; focus, exposure and a lamp "
    "drift, and in week 25 the camera is exchanged. Percent of the pictures that are right, and references learned. "
    "Summary: means over the lines, and of all lines the least of learned less commissioned."
)
WEEKS, VIEWS, EXCHANGED_WEEK = 50, 2, 25
KINDS = {"typical": lambda label, rng: face(TYPICAL[label], rng), "foreign": foreign_face, "cast": cast_face}
LINES = {("cast", "relief"): 12, ("foreign", "relief"): 12, ("typical", "dual"): 12, ("typical", "single"): 4}
WAYS = ("none", "agreement", "operator", "operator_5_percent_wrong")
SURE_LOG_ODDS = 3.0
WRONG_SHARE = 0.05
SAMPLE = 1


def cases():
    return [
        {"kind": kind, "classifier": classifier, "seed": seed}
        for (kind, classifier), lines in LINES.items()
        for seed in range(lines)
    ]


def run(case):
    line = _Line(case["kind"], case["seed"])
    first = tuple(line.views(label)[0] for label in LABELS)
    learners = {way: ReferenceLearner(first, first, case["classifier"]) for way in WAYS}
    rng = np.random.default_rng([case["seed"], 7])
    right, learned = {way: [0] * WEEKS for way in WAYS}, dict.fromkeys(WAYS, 0)
    for week in range(WEEKS):
        line.drift(exchange=week == EXCHANGED_WEEK)
        for label in LABELS:
            views, wrong = line.views(label), rng.random() < WRONG_SHARE
            for way, learner in learners.items():
                odds = _log_odds(case["classifier"], learner.current, views)
                right[way][week] += sum((one > 0) == (label == "top") for one in odds)
                confirmed = _confirmed(way, odds, is_top=label == "top", wrong=wrong)
                if confirmed is not None:
                    learned[way] += learner.add(views[0], is_top=confirmed)
    return {way: {"learned": learned[way], **_percent(right[way])} for way in WAYS}


def _percent(right):
    weeks = np.array(right) / (0.01 * len(LABELS) * VIEWS)
    return {
        "all": round(float(weeks.mean()), 2),
        "before_the_new_camera": round(float(weeks[:EXCHANGED_WEEK].mean()), 2),
        "with_the_new_camera": round(float(weeks[EXCHANGED_WEEK:].mean()), 2),
    }


def _confirmed(way, odds, *, is_top, wrong):
    """Which end an ingot is taken to show, or None."""
    if way == "none":
        return None
    if way == "agreement":
        sure = min(odds) > 0 or max(odds) < 0
        return odds[0] > 0 if sure and abs(float(np.mean(odds))) > SURE_LOG_ODDS else None
    return is_top != (wrong and way == "operator_5_percent_wrong")


def _log_odds(name, references, images):
    judge = FaceJudge(references, name)
    return [judge.verdict(judge.face(image)).log_odds for image in images]


class _Line:
    """A line whose camera and lamp drift."""

    def __init__(self, kind, seed):
        self._draw, self._rng = KINDS[kind], np.random.default_rng([seed, 50])
        self._camera, self._lamp = random_camera(self._rng), np.zeros(2)

    def drift(self, *, exchange):
        rng, camera = self._rng, random_camera(self._rng) if exchange else self._camera
        self._camera = camera._replace(
            blur_px=float(np.clip(camera.blur_px * np.exp(rng.normal(0, 0.05)), 0.35, 1.6)),
            peak=float(np.clip(camera.peak * np.exp(rng.normal(0, 0.06)), 0.2, 0.8)),
        )
        self._lamp = 0.95 * self._lamp + rng.normal(0, 0.04, 2)

    def views(self, label):
        light = self._draw(label, self._rng)
        return [self._lit(rendered_end(light, self._camera, self._rng)) for _ in range(VIEWS)]

    def _lit(self, image):
        """The lamp lies on the end from one side."""
        down, across = np.mgrid[-1 : 1 : image.shape[0] * 1j, -1 : 1 : image.shape[1] * 1j]
        lit = image * (1 + self._lamp[0] * across + self._lamp[1] * down)
        return np.asarray(cv2.convertScaleAbs(lit), np.uint8)


def summary(rows):
    kinds = {f"{kind}, {name}": _of(kind, name, rows) for kind, name in LINES}
    return {title: {way: _way(of, way) for way in WAYS} for title, of in kinds.items()}


def _of(kind, classifier, rows):
    return [row for row in rows if (row["kind"], row["classifier"]) == (kind, classifier)]


def _way(rows, way):
    means = {
        name: round(statistics.mean(row[way][name] for row in rows), 2)
        for name in ("all", "before_the_new_camera", "with_the_new_camera", "learned")
    }
    gained = [row[way]["all"] - row["none"]["all"] for row in rows]
    return means | {"lines": len(rows), "least_gain": round(min(gained), 2)}
