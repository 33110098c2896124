"""Frames without a measurable bar, or of a rig that is not as it was calibrated: no value, or one that is right."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from calibrated_rigs import off_response, rig_with_marks

from appliance.cameras.liveness import Exposure, Liveness
from appliance.cameras.settings import LivenessSettings
from appliance.simulation.bars.study_scenes import set_up
from studies.served_diameter import is_wrong, told
from vision.sizing.gauge import Gauge

TEXT = (
    "The gauge as served, both routes and still marks, rigs and calibrations as in served_diameter, 800 x 600. A value "
    "is wrong when |error| > max(2 U, 1 mm), or when nothing is there to be measured. Frozen pictures are judged by "
    "what the station asks before it measures; gauge_alone says what they would have given without."
)
SEEDS = range(500, 600)
NUDGE_DEG = 0.05
LIKE_DEG = (0.2, 4)
SIDES = ("left", "right")
PERIOD_S = 0.1


class Shown(NamedTuple):
    """A pair of pictures, the diameter that could be measured in them (None: none), and the seed of the gauge's rig."""

    left: np.ndarray
    right: np.ndarray
    truth_mm: float | None
    rig_seed: int


def drawn(condition, seed, **changes):
    """A scene of the mill with changes to its set-up."""
    setup = replace(set_up(condition, seed), **changes)
    return Shown(*setup.pair(), setup.diameter_mm, seed)


def overexposed(seed, rng):
    return drawn("clean", seed, gain=between(rng, 4, 40))


def out_of_focus(seed, rng):
    blur = replace(set_up("clean", seed).blur, core_px=between(rng, 1.5, 15))
    return drawn("clean", seed, blur=blur)


def between(rng, low, high):
    """A factor between two, small ones as often as large ones."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def frozen(seed, rng):
    """Another bar has come, and one camera or both still show the one before."""
    before = drawn("clean", seed)
    bar = set_up("clean", seed).bars[0]
    moved = replace(bar, diameter_mm=bar.diameter_mm + rng.uniform(-30, 30), offset_mm=rng.uniform(-50, 50))
    now = drawn("clean", seed, bars=(moved,))
    sides = (SIDES[:1], SIDES[1:], SIDES)[rng.integers(3)]
    return now._replace(**{side: getattr(before, side) for side in sides})


def swapped(seed, _):
    right_way = drawn("clean", seed)
    return right_way._replace(left=right_way.right, right=right_way.left)


def another_rig(seed, _):
    return drawn("clean", seed)._replace(rig_seed=seed + 1)


def like_rig(seed, rng):
    """Cameras at the same places that look elsewhere, as those of the next line do, or after they were mounted anew."""
    return drawn("clean", seed, nudges={side: turn(rng, between(rng, *LIKE_DEG)) for side in SIDES})


def nudged(seed, rng):
    side = SIDES[rng.integers(2)]
    return drawn("clean", seed, nudges={side: turn(rng, NUDGE_DEG)})


def turn(rng, degrees):
    axis = rng.normal(0, 1, 3)
    return tuple((degrees * axis / np.linalg.norm(axis)).tolist())


def of_the_mill(condition):
    return lambda seed, _: drawn(condition, seed)


CASES = {
    "no bar": of_the_mill("no-bar"),
    "one camera only": of_the_mill("one-blind"),
    "two bars": of_the_mill("two-bars"),
    "bar leaving the region": of_the_mill("bar-end"),
    "overexposed 4 to 40 times": overexposed,
    "out of focus by 1.5 to 15 px": out_of_focus,
    "frozen": frozen,
    "left and right swapped": swapped,
    "calibration of another rig": another_rig,
    "calibration of a like rig": like_rig,
    "camera nudged by 0.05 degrees": nudged,
}


def cases():
    return [{"case": name, "seed": seed} for seed in SEEDS for name in CASES]


def shown(name, seed):
    one = CASES[name](seed, np.random.default_rng([seed, 0x6E6F]))
    return one._replace(left=off_response(one.left, seed), right=off_response(one.right, seed))


def run(case):
    seen = shown(case["case"], case["seed"])
    result = told(Gauge(rig_with_marks(seen.rig_seed), 0.0).measure(seen.left, seen.right), seen.truth_mm)
    if case["case"] != "frozen":
        return result
    faults = faults_of_frozen(seen, case["seed"])
    served = {"truth_mm": seen.truth_mm, "valid": False, "reasons": faults} if faults else result
    return served | {"gauge_alone": "wrong" if is_wrong(result) else "right" if result["valid"] else "no value"}


def faults_of_frozen(seen, seed):
    """Faults that the station finds when these pictures follow the ones before; none when it would measure them."""
    liveness = Liveness(LivenessSettings(), 0.0, numbered=False)
    before = drawn("clean", seed)
    first = tuple(off_response(picture, seed) for picture in (before.left, before.right))
    verdict = None
    for number, pictures in enumerate((first, (seen.left, seen.right))):
        moment_s = (number + 1) * PERIOD_S
        stamps = (round(1e6 * moment_s),) * 2
        exposure = Exposure(pictures, stamps, moment_s, dropped=0, repeated=False)
        verdict = liveness.judge(exposure, moment_s + LivenessSettings().lost_after_ms / 1000)
    return [] if verdict.counts else list(verdict.faults)


def summary(rows):
    return {name: _of_case([row for row in rows if row["case"] == name]) for name in CASES} | {"all": _of_case(rows)}


def _of_case(rows):
    reasons = [reason for row in rows if not row["valid"] for reason in row["reasons"]]
    measurable = [row for row in rows if row["truth_mm"] is not None and row["valid"]]
    told_of = {
        "frames": len(rows),
        "measurable": sum(row["truth_mm"] is not None for row in rows),
        "no_value": sum(not row["valid"] for row in rows),
        "right_values": sum(row["valid"] and not is_wrong(row) for row in rows),
        "wrong_values": sum(map(is_wrong, rows)),
        "worst_of_values_mm": max((abs(row["error_mm"]) for row in measurable), default=None),
        "without_a_value_because": {name: reasons.count(name) for name in sorted(set(reasons))},
    }
    alone = [row["gauge_alone"] for row in rows if "gauge_alone" in row]
    return told_of | ({"gauge_alone": {name: alone.count(name) for name in sorted(set(alone))}} if alone else {})
