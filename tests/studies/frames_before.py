"""What a reading owes to the frames before it: a gauge that has seen them beside a new one for every frame."""

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
from calibrated_rigs import off_response, rig_with_marks

from appliance.simulation.bars.study_scenes import set_up
from studies.served_diameter import rounded
from vision.sizing.gauge import Gauge

TEXT = (
    "The gauge as served, both routes and still marks, rigs and calibrations as in served_diameter, 800 x 600. Each "
    "case is a sequence of 25 frames of one line: bars stay for 1 to 8 frames, jump in size and place, are hidden, "
    "leave, come in twos, swap between both exposures, and a camera turns. One gauge measures the sequence; another, "
    "new one measures each of its pairs alone, with nothing to go by but a search of the whole region."
)
SEEDS = range(700, 740)
SEQUENCES = 10  # of each seed's line
FRAMES = 25
LONGEST_STAY = 8
CHUNK = SEQUENCES  # cases of one seed share its line
SAMPLE = 1
CONDITIONS = ("clean", "scale", "post", "haze", "glare", "overexposed", "bar-end", "two-bars", "no-bar", "one-blind")
OTHERS = ("jumped", "thin", "moved aside", "nudged", "swapped")


def cases():
    return [{"seed": seed, "sequence": sequence} for seed in SEEDS for sequence in range(SEQUENCES)]


def run(case):
    rng = np.random.default_rng([case["seed"], case["sequence"], 0x6662])
    running = Gauge(rig_with_marks(case["seed"]), 0.0)
    names = sequence(rng)
    return compared([(running.measure(*shown(case["seed"], name)), alone(case["seed"], name)) for name in names])


def sequence(rng):
    """Names of the frames, one after the other."""
    names = []
    while len(names) < FRAMES:
        name = (*CONDITIONS, *OTHERS)[rng.integers(len(CONDITIONS) + len(OTHERS))]
        names += [name] * int(rng.integers(1, LONGEST_STAY + 1))
    return names[:FRAMES]


@lru_cache(maxsize=32)
def shown(seed, name):
    """A pair of pictures of a seed's line."""
    if name == "swapped":  # the left camera has exposed before the bars changed, the right one after
        return shown(seed, "clean")[0], shown(seed, "jumped")[1]
    return tuple(off_response(picture, seed) for picture in drawn(seed, name).pair())


def drawn(seed, name):
    if name in CONDITIONS:
        return set_up(name, seed)
    if name == "nudged":
        return set_up("clean", seed, effects=("nudged",))
    rng = np.random.default_rng([seed, 0x6A75])
    setup = set_up("clean", seed)
    bar = setup.bars[0]
    jumped = replace(bar, diameter_mm=bar.diameter_mm + rng.uniform(20, 60), offset_mm=rng.uniform(-50, 50))
    other = {
        "jumped": jumped,
        "thin": replace(bar, diameter_mm=rng.uniform(60, 90)),
        "moved aside": replace(bar, offset_mm=-bar.offset_mm + rng.choice([-20, 20])),
    }
    return replace(setup, bars=(other[name],))


@lru_cache(maxsize=32)
def alone(seed, name):
    """The reading of a gauge that has seen nothing before."""
    return Gauge(rig_with_marks(seed), 0.0).measure(*shown(seed, name))


def compared(readings):
    """How the readings of a running gauge differ from those of new ones."""
    apart = [abs(one.diameter_mm - other.diameter_mm) for one, other in readings]
    virtual = [abs(one.diameter_virtual_board_mm - other.diameter_virtual_board_mm) for one, other in readings]
    both = [(one.reasons, other.reasons) for one, other in readings]
    return {
        "values": sum(one.valid for one, _ in readings),
        "values_that_a_search_refuses": sum(one.valid and not other.valid for one, other in readings),
        "values_that_are_missed": sum(other.valid and not one.valid for one, other in readings),
        "other_reasons": sum(one != other for one, other in both),
        "apart_mm": rounded(largest(apart)),
        "virtual_board_apart_mm": rounded(largest(virtual)),
    }


def largest(values):
    return max((value for value in values if math.isfinite(value)), default=0.0)


def summary(rows):
    counts = ("values", "values_that_a_search_refuses", "values_that_are_missed", "other_reasons")
    return (
        {"frames": FRAMES * len(rows)}
        | {name: sum(row[name] for row in rows) for name in counts}
        | {name: max(row[name] for row in rows) for name in ("apart_mm", "virtual_board_apart_mm")}
    )
