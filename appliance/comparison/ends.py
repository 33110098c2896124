"""Verdicts on ingots' ends held against the truth, frame by frame and ingot by ingot."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from appliance.comparison.confusion import Confusion
from appliance.comparison.files import EndTruth

SAME_WITHIN_FRAMES = 5  # frames without an ingot in the truth that do not part two
EARLY_FRAMES = 8  # frames before its own truth in which an ingot may be seen, behind one that is leaving


class Followed(NamedTuple):
    """An ingot of the truth, and what was decided of it; frames until the decision are counted on the line."""

    label: str
    decision: str
    frames_until: int | None


class Decided(NamedTuple):
    """A decision on an ingot, as `orient` writes it."""

    orientation: str
    first_frame: int
    decided_frame: int | None


@dataclass(frozen=True, slots=True)
class Similarities:
    """Similarity of ends to the top reference: table 6.1."""

    count: int
    largest: float
    least: float
    mean: float


@dataclass(frozen=True, slots=True)
class EndComparison:
    """What the comparison of a sequence says.

    Attributes
    ----------
    placed, found, found_elsewhere : int
        Frames with an ingot on the line, those with an end found, and frames without an ingot in which one was found.
    confusion : Confusion
        Of the frames with an end found.
    similarities : dict of str to Similarities
        By true label.
    ingots : list of Followed
    strangers : list of Decided
        Decisions without an ingot.
    """

    placed: int
    found: int
    found_elsewhere: int
    confusion: Confusion
    similarities: dict[str, Similarities]
    ingots: list[Followed]
    strangers: list[Decided]


def compared_ends(rows: Sequence[dict[str, Any]], truth: Mapping[int, EndTruth]) -> EndComparison:
    """Compare rows of `orient` with the truth.

    Parameters
    ----------
    rows : sequence of dict
        Rows of frames, and rows of ingots among them.
    truth : mapping of int to EndTruth
    """
    seen = [(truth[row["frame"]], row) for row in rows if row.get("frame") in truth]
    placed = [(true, row) for true, row in seen if true.present and true.state == "placed"]
    found = [(true, row) for true, row in placed if row["present"]]
    elsewhere = [1 for true, row in seen if row["present"] and not true.present and true.state not in _ON_LINE]
    decisions = [
        Decided(row["orientation"], row["first_frame"], row.get("decided_frame"))
        for row in rows
        if row.get("ingot") is not None
    ]
    ingots, strangers = matched(truth, decisions)
    return EndComparison(
        len(placed),
        len(found),
        len(elsewhere),
        Confusion.of((true.label, row["orientation"]) for true, row in found),
        {label: _similarities([row["ssim_top"] for true, row in found if true.label == label]) for label in _LABELS},
        ingots,
        strangers,
    )


_ON_LINE = frozenset({"placed", "leaving"})
_LABELS = ("top", "bottom")


def _similarities(values: Sequence[float]) -> Similarities:
    if not values:
        return Similarities(0, math.nan, math.nan, math.nan)
    return Similarities(len(values), max(values), min(values), math.fsum(values) / len(values))


def matched(truth: Mapping[int, EndTruth], decisions: Sequence[Decided]) -> tuple[list[Followed], list[Decided]]:
    """Ingots of the truth with the decision that fell while they were on the line, and decisions without an ingot.

    Parameters
    ----------
    truth : mapping of int to EndTruth
    decisions : sequence of Decided
    """
    left = list(decisions)
    ingots: list[Followed] = []
    for label, first, last in _spans(truth):
        mine = [one for one in left if first - EARLY_FRAMES <= one.first_frame <= last]
        left = [one for one in left if one not in mine]
        told = [one for one in mine if one.orientation != "undecided"] or mine
        orientation = told[0].orientation if told else "undecided"
        decided = told[0].decided_frame if told else None
        ingots.append(Followed(label, orientation, None if decided is None else decided - first + 1))
        left += told[1:]
    return ingots, left


def _spans(truth: Mapping[int, EndTruth]) -> list[tuple[str, int, int]]:
    """Label, first and last frame of each ingot on the line."""
    spans: list[tuple[str, int, int]] = []
    for frame, true in sorted(truth.items()):
        if not (true.present and true.state in _ON_LINE):
            continue
        new = not spans or true.label != spans[-1][0] or frame > spans[-1][2] + SAME_WITHIN_FRAMES
        if new and true.state == "placed":
            spans.append((true.label, frame, frame))
        elif spans:
            spans[-1] = (*spans[-1][:2], frame)
    return spans


def end_lines(found: EndComparison) -> list[str]:
    """Table of a comparison, for people."""
    counts = found.confusion
    right = sum(one.label == one.decision for one in found.ingots)
    undecided = sum(one.decision == "undecided" for one in found.ingots)
    false_alarms = sum((one.label, one.decision) == ("bottom", "top") for one in found.ingots)
    false_alarms += sum(one.orientation == "top" for one in found.strangers)
    elsewhere = f"end found in {found.found}, and in {found.found_elsewhere} without"
    lines = [
        f"frames          {found.placed} with an ingot on the line; {elsewhere}",
        f"{'true':16}{'as top':>10}{'as bottom':>12}{'undecided':>12}{'precision':>12}{'recall':>10}",
        _confusion_line("top", counts, counts.top_as_top, counts.top_as_bottom, counts.top_undecided),
        _confusion_line("bottom", counts, counts.bottom_as_top, counts.bottom_as_bottom, counts.bottom_undecided),
        f"accuracy        {_number(counts.accuracy)}",
        f"{'SSIM with top':16}{'ends':>10}{'largest':>12}{'least':>12}{'mean':>12}",
    ]
    for label, one in found.similarities.items():
        cells = "".join(f"{_number(value):>12}" for value in (one.largest, one.least, one.mean))
        lines.append(f"{label:16}{one.count:>10}{cells}")
    strangers = sum(one.orientation != "undecided" for one in found.strangers)
    others = f"{undecided} undecided, {false_alarms} false alarms, {strangers} decisions without an ingot"
    return [*lines, f"ingots          {right} of {len(found.ingots)} right, {others}"]


def _confusion_line(label: str, counts: Confusion, as_top: int, as_bottom: int, undecided: int) -> str:
    label_of = "top" if label == "top" else "bottom"
    rates = f"{_number(counts.precision(label_of)):>12}{_number(counts.recall(label_of)):>10}"
    return f"{label:16}{as_top:>10}{as_bottom:>12}{undecided:>12}{rates}"


def _number(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.4f}"
