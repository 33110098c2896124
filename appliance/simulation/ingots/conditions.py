"""Ingot lines for studies: a line, its ingots and everything around them drawn from a seed, under a named condition.

`INGOT_CONDITIONS` is the one table of what can be drawn. The same seed gives the same line under every condition.
"""

import math
import zlib
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from appliance.simulation.ingots.faces import Rng
from appliance.simulation.ingots.line import IMAGE_SIZE, Habits, IngotLine, random_line
from appliance.simulation.ingots.sequence import IngotSequence

QUIET = Habits(glare_share=0.0, overexposed_share=0.0, drift=(1.0, 1.0))
MOVED_PX = 10.0

Change = Callable[[IngotLine, Rng], IngotLine]


def ingot_sequence(
    seed: int, condition: str = "mixed", ingots: int | None = 2, image_size: tuple[int, int] = IMAGE_SIZE
) -> IngotSequence:
    """Sequence of some ingots, one after the other, under a condition of `INGOT_CONDITIONS`.

    Parameters
    ----------
    seed : int
        Line, ingots, patterns, times and noise.
    condition : str
    ingots : int or None
        How many pass; None goes on for ever.
    image_size : tuple of int
        (columns, rows), pixels.

    Raises
    ------
    ValueError
        `condition` is not in the table.
    """
    return IngotSequence(ingot_line(seed, condition, image_size), ingots)


def ingot_line(seed: int, condition: str = "mixed", image_size: tuple[int, int] = IMAGE_SIZE) -> IngotLine:
    """The line that `ingot_sequence` shows; raises `ValueError` when `condition` is not in the table."""
    rows = {row.name: row for row in INGOT_CONDITIONS}
    if condition not in rows:
        raise ValueError(f"condition: {condition!r} is not a condition of the simulated ingot line")
    row = rows[condition]
    rng = np.random.default_rng([seed, zlib.crc32(condition.encode())])
    return row.change(random_line(seed, row.habits, image_size), rng)


def _as_it_is(line: IngotLine, _: Rng) -> IngotLine:
    return line


def _camera_moved(line: IngotLine, rng: Rng) -> IngotLine:
    direction = rng.uniform(0, 2 * math.pi)
    turn = math.degrees(math.atan(MOVED_PX / line.camera.K[0, 0]))
    return replace(line, turned_deg=(turn * math.sin(direction), turn * math.cos(direction), 0.0))


def _exposure_changed(line: IngotLine, rng: Rng) -> IngotLine:
    return replace(line, gain=float(rng.choice([0.5, 2.0])))


class IngotCondition(NamedTuple):
    """One row of the table."""

    name: str
    text: str
    habits: Habits
    change: Change = _as_it_is


INGOT_CONDITIONS: tuple[IngotCondition, ...] = (
    IngotCondition("mixed", "ingots one after the other; some with glare, drift or overexposure", Habits()),
    IngotCondition("foreign", "as mixed, but ends look like another mill's", Habits(faces="foreign")),
    IngotCondition("cast", "as mixed, but ends are shaded as their geometry is", Habits(faces="cast")),
    IngotCondition("clean", "steady light, no glare", QUIET),
    IngotCondition(
        "glare",
        "a bright reflection on the line borders the ingot for a part of its way",
        replace(QUIET, glare_share=1.0, touching_share=1.0),
    ),
    IngotCondition(
        "overexposed",
        "the camera takes 1.5 to 2.3 times too much light for a while",
        replace(QUIET, overexposed_share=1.0),
    ),
    IngotCondition(
        "drift", "ingots become 1.5 to 2.2 times brighter towards the rolls", replace(QUIET, drift=(1.5, 2.2))
    ),
    IngotCondition(
        "hanging-only", "the crane holds ingots over the line and takes them away again", replace(QUIET, set_down=False)
    ),
    IngotCondition("empty", "no ingot comes", replace(QUIET, ingots=False)),
    IngotCondition(
        "glare-alone", "no ingot comes, bright reflections come and go", replace(QUIET, ingots=False, glare_share=1.0)
    ),
    IngotCondition("two", "two ingots are on the line together, one behind the other", replace(QUIET, in_view=2)),
    IngotCondition(
        "camera-moved", "the picture has moved by 10 px since regions and references were made", QUIET, _camera_moved
    ),
    IngotCondition(
        "exposure-changed", "half or twice the exposure with which the references were made", QUIET, _exposure_changed
    ),
)
