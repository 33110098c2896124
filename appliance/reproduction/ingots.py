"""Chapter 6: which end of an ingot faces the line, in two sets of videos (tables 6.1 to 6.3, figures 6.12 to 6.21)."""

import csv
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from appliance.cameras.recording.picture_file import read_picture
from appliance.comparison.confusion import Confusion
from appliance.ingot.reader_setup import load_view, make_reader
from appliance.ingot.settings import IngotSettings
from appliance.reproduction.experiment import Case, Experiment, Plot, Result, Section, Table, number
from appliance.simulation.ingots.conditions import ingot_sequence
from vision.ingot.classifiers.ssim import SIMILARITY_THRESHOLD, dual, single
from vision.ingot.end_finder import Box
from vision.ingot.orientation_reader import IngotView, References

FIRST_SET, SECOND_SET = 4, 12  # videos, half of them tops
ENDS = 1329  # of both sets, section 6.5
QUICK_VIDEOS = (2, 2)
CLASSIFIERS = ("single", "dual", "relief")
PRINTED = {  # precision and recall of tops, accuracy: tables 6.2 and 6.3
    "single": (1.0, 0.8134, 0.9180),
    "dual": (1.0, 0.9589, 0.9819),
}
PRINTED_SIMILARITY = {  # largest, least, mean: table 6.1
    "bottom-1": (0.6905, 0.3667, 0.5562),
    "bottom-2": (0.5934, 0.4036, 0.4976),
    "top-1": (0.7985, 0.5517, 0.7139),
    "top-2": (0.9021, 0.6802, 0.7901),
}
LABELS = ("top", "bottom")
LINES = ("ingot_line", "ingot_line_b")  # recordings with truth that may be judged as well


class IngotEnds(Experiment):
    """The dissertation's two classifiers and the served one, on simulated videos and on recorded ones."""

    name: ClassVar[str] = "ingots"

    def __init__(self, recordings: Path | None = None) -> None:
        self._recordings = recordings

    def cases(self, *, quick: bool) -> list[Case]:
        """One video each."""
        counts = QUICK_VIDEOS if quick else (FIRST_SET, SECOND_SET)
        told: list[Case] = [
            {"set": place, "video": video, "label": LABELS[video % 2]}
            for place, count in enumerate(counts)
            for video in range(count)
        ]
        for line in LINES if self._recordings is not None else ():
            folder = Path(str(self._recordings)) / line
            told += [{"set": line, "video": path.name, "label": ""} for path in sorted(folder.glob("seq*"))]
        return told

    def run(self, case: Case) -> Result:
        """Label, similarities and the served verdict of each end that was found while its ingot lay on the line."""
        frames = self._recorded(case) if isinstance(case["set"], str) else _simulated(case)
        reader = None
        ends: list[list[Any]] = []
        for view, picture, label in frames:
            reader = reader or make_reader(IngotSettings(classifier="relief"), view, picture)
            reading = reader.read(picture)
            if reading.present:
                ends.append([label, round(reading.ssim_top, 4), round(reading.ssim_bottom, 4), reading.orientation])
        return {"ends": ends}

    def _recorded(self, case: Case) -> Iterator[tuple[IngotView, Any, str]]:
        if self._recordings is None:
            return
        folder = self._recordings / case["set"]
        view = load_view(folder)
        with (folder / case["video"] / "truth.csv").open(encoding="utf-8") as file:
            for row in csv.DictReader(file):
                if row["present"] == "1" and row["state"] == "placed":
                    yield (
                        view,
                        read_picture(folder / case["video"] / f"{int(row['frame']):06d}.jpg").shown,
                        row["label"],
                    )

    def section(self, results: Sequence[tuple[Case, Result]]) -> Section:
        """Tables 6.1 to 6.3 and figures 6.12 to 6.21."""
        simulated = [(case, result) for case, result in results if not isinstance(case["set"], str)]
        ends = [end for _, result in simulated for end in result["ends"]]
        tables = [_similarities(simulated), _classified(f"Tables 6.2 and 6.3, simulated: {len(ends)} ends", ends)]
        recorded = [end for case, result in results if isinstance(case["set"], str) for end in result["ends"]]
        if recorded:
            tables.append(_classified(f"The same on path-traced recordings: {len(recorded)} ends", recorded))
        accuracy = {name: _confusion(ends, name).accuracy for name in CLASSIFIERS}
        better = "confirmed" if accuracy["dual"] > accuracy["single"] else "contradicted"
        return Section(
            "Ingots' ends (chapter 6)",
            f"{len(simulated)} simulated videos, each its own line, light and ingot; {len(ends)} ends (the "
            f"dissertation has {ENDS:,} from 16 videos). Similarities are with the references of the line.",
            tables,
            [
                Plot(
                    "similarity",
                    "Figures 6.13 and 6.16: similarity with the top reference",
                    partial(_figure, ends=ends),
                ),
                Plot(
                    "dual",
                    "Figures 6.19 and 6.20: similarity with the top less that with the bottom",
                    partial(_figure_dual, ends=ends),
                ),
            ],
            [
                f"Dual is better than single: {better} (accuracy {accuracy['dual']:.3f} and {accuracy['single']:.3f}).",
                (
                    "One reference top is one pattern; other tops differ from it in the width and place of their "
                    "wrinkles, so a threshold of 0.75 that fits one mill fits no other."
                ),
                f"The served network, beside both references, has an accuracy of {accuracy['relief']:.3f}.",
            ],
        )


def _simulated(case: Case) -> Iterator[tuple[IngotView, Any, str]]:
    """Frames of an ingot on the line; seeds are searched for one whose ingot shows the wanted end."""
    seed = 50_000 + 1000 * case["set"] + 100 * case["video"]
    while True:
        sequence = ingot_sequence(seed, "mixed", 1)
        placed = [(picture, told) for picture, told in sequence.frames if told.present and told.state == "placed"]
        if placed and placed[0][1].label == case["label"]:
            break
        seed += 1
    references = References(sequence.references["top"], sequence.references["bottom"])
    view = IngotView(references, Box(*sequence.roi_crop), Box(*sequence.roi_centroid))
    for picture, told in placed:
        yield view, picture, str(told.label)


def _verdict(end: Sequence[Any], classifier: str) -> str:
    if classifier == "single":
        return single(end[1])
    return dual(end[1], end[2]) if classifier == "dual" else str(end[3])


def _confusion(ends: Sequence[Sequence[Any]], classifier: str) -> Confusion:
    return Confusion.of((end[0], _verdict(end, classifier)) for end in ends)


def _classified(title: str, ends: Sequence[Sequence[Any]]) -> Table:
    rows: list[tuple[str, ...]] = []
    for name in CLASSIFIERS:
        counts = _confusion(ends, name)
        ours = counts.precision("top"), counts.recall("top"), counts.accuracy
        printed: tuple[float | None, ...] = PRINTED.get(name, (None, None, None))
        cells = [
            f"{number(theirs, '.4f')} / {number(value, '.4f')}" for theirs, value in zip(printed, ours, strict=True)
        ]
        confusion = f"{counts.top_as_top}, {counts.top_as_bottom} / {counts.bottom_as_top}, {counts.bottom_as_bottom}"
        rows.append((f"{name}, served" if name == "relief" else name, *cells, confusion))
    columns = ("", "precision of tops", "recall of tops", "accuracy", "top as top, bottom / bottom as top, bottom")
    return Table(f"{title}; dissertation / here", columns, rows)


def _similarities(results: Sequence[tuple[Case, Result]]) -> Table:
    first = [(case, result) for case, result in results if case["set"] == 0 and result["ends"]]
    rows: list[tuple[str, ...]] = [
        (f"dissertation, 40 ingoing {name}", *(number(value, ".4f") for value in values))
        for name, values in PRINTED_SIMILARITY.items()
    ]
    for case, result in first:
        values = [end[1] for end in result["ends"]]
        cells = (number(value, ".4f") for value in (max(values), min(values), float(np.mean(values))))
        rows.append((f"here, video {case['video'] + 1}, {case['label']}", *cells))
    return Table("Table 6.1: similarity with the top reference", ("", "largest", "least", "mean"), rows)


def _figure(axes: Any, ends: Sequence[Sequence[Any]]) -> None:
    for label, colour in (("top", "tab:red"), ("bottom", "tab:blue")):
        values = [end[1] for end in ends if end[0] == label]
        axes.plot(values, ".", ms=3, color=colour, label=f"truly {label}")
    axes.axhline(SIMILARITY_THRESHOLD, color="black", linewidth=0.8, linestyle="--", label="threshold 0.75")
    axes.set(xlabel="end", ylabel="structural similarity")


def _figure_dual(axes: Any, ends: Sequence[Sequence[Any]]) -> None:
    for label, colour in (("top", "tab:red"), ("bottom", "tab:blue")):
        values = [end[1] - end[2] for end in ends if end[0] == label]
        axes.plot(values, ".", ms=3, color=colour, label=f"truly {label}")
    axes.axhline(0, color="black", linewidth=0.8, linestyle="--")
    axes.set(xlabel="end", ylabel="difference of similarities")
