"""Chapter 6: which end of an ingot faces the line, in two sets of videos (tables 6.1 to 6.3, figures 6.12 to 6.21)."""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from appliance.cameras.recording.picture_file import read_picture
from appliance.comparison.confusion import Confusion
from appliance.ingot.reader_setup import ingot_regions, load_view, make_finder, make_reader
from appliance.ingot.settings import IngotSettings
from appliance.reproduction.experiment import Case, Experiment, Plot, Result, Section, Table, number
from appliance.reproduction.sampling import mean_with_error, share, verdict
from appliance.simulation.ingots.conditions import ingot_line
from appliance.simulation.ingots.faces import Label
from appliance.simulation.ingots.line import IngotLine
from appliance.simulation.ingots.sequence import IngotSequence
from appliance.simulation.ingots.timetable import timetable
from vision.ingot.classifiers.ssim import SIMILARITY_THRESHOLD, dual, single
from vision.ingot.end_finder import Box
from vision.ingot.end_image import end_image
from vision.ingot.orientation_reader import IngotView, References

FIRST_SET, SECOND_SET = 4, 12  # videos, half of them tops
ENDS = 1329  # of both sets, section 6.5
QUICK_VIDEOS = (2, 2)
CLASSIFIERS = ("single", "dual", "relief")
PRINTED = {  # figures 6.17 and 6.21: tops as top and as bottom, bottoms as top and as bottom
    "single": Confusion(475, 109, 0, 745),
    "dual": Confusion(560, 24, 0, 745),
}
PRINTED_SIMILARITY = {  # largest, least, mean: table 6.1
    "bottom-1": (0.6905, 0.3667, 0.5562),
    "bottom-2": (0.5934, 0.4036, 0.4976),
    "top-1": (0.7985, 0.5517, 0.7139),
    "top-2": (0.9021, 0.6802, 0.7901),
}
LABELS: tuple[Label, Label] = ("top", "bottom")
LINES = ("ingot_line", "ingot_line_b")  # recordings with truth that may be judged as well
ITSELF = 0.9999  # a similarity above it is an end's with itself: the reference's own picture is left out
MILL_SEED = 50_000  # of the one line that all videos show


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
        """Label, similarities and the served verdict of each end that was found while its ingot lay on the line.

        Similarities are with ends out of the videos themselves, as in the dissertation; the served classifier has the
        references that the line was commissioned with, and on recordings both have those.
        """
        if isinstance(case["set"], str):
            frames, chosen = self._recorded(case), None
        else:
            frames, chosen = _simulated(_video_line(case)), _chosen_references()
        readers = None
        ends: list[list[Any]] = []
        for view, picture, label in frames:
            readers = readers or (
                make_reader(IngotSettings(classifier="relief"), view, picture),
                make_reader(
                    IngotSettings(classifier="dual"),
                    view if chosen is None else replace(view, references=chosen),
                    picture,
                ),
            )
            served, similar = (reader.read(picture) for reader in readers)
            is_reference = max(similar.ssim_top, similar.ssim_bottom) > ITSELF
            if served.present and not is_reference:
                ends.append([label, round(similar.ssim_top, 4), round(similar.ssim_bottom, 4), served.orientation])
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
        videos = [result["ends"] for _, result in simulated if result["ends"]]
        ends = [end for video in videos for end in video]
        tables = [_similarities(simulated), *_classified("Tables 6.2 and 6.3, simulated", videos)]
        recorded = [result["ends"] for case, result in results if isinstance(case["set"], str) and result["ends"]]
        if recorded:
            tables += _classified("The same on path-traced recordings", recorded)
        return Section(
            "Ingots' ends (chapter 6)",
            f"{len(videos)} simulated videos of one line, each its own ingot, light and glare; {len(ends)} ends (the "
            f"dissertation has {ENDS:,} from 16 videos). References are an end of the first video of each kind, as the "
            "dissertation chose its own, and are left out; the served classifier has the two that the line was "
            "commissioned with.",
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
            _findings(videos),
        )


def _findings(videos: Sequence[Sequence[Sequence[Any]]]) -> list[str]:
    accuracy = {name: [_confusion(video, name).accuracy for video in videos] for name in CLASSIFIERS}
    ahead = [dual_ - single_ for dual_, single_ in zip(accuracy["dual"], accuracy["single"], strict=True)]
    wrong = {name: sum(_confusion(video, name).bottom_as_top for video in videos) for name in CLASSIFIERS}
    bottoms = sum(end[0] == "bottom" for video in videos for end in video)
    return [
        f"Dual is better than single: {verdict(ahead)}, accuracy {mean_with_error(ahead, '+.3f')} higher by video.",
        (
            f"No bottom is called a top, as in the dissertation: by single {share(wrong['single'], bottoms)}, by dual "
            f"{share(wrong['dual'], bottoms)} (intervals as if ends were independent)."
        ),
        (
            "One reference top is one pattern. The simulated mill's tops differ in the number, depth and course of "
            "their wrinkles, so many are more like the smooth reference; the dissertation's were like its own (table "
            "6.1). Which is a mill's case, hotgauge compare tells from its own pictures."
        ),
        (
            f"The served network, beside both references of the line: accuracy "
            f"{mean_with_error(accuracy['relief'], '.3f')}."
        ),
    ]


@lru_cache(maxsize=1)
def _mill() -> IngotLine:
    return ingot_line(MILL_SEED, "mixed")


def _video_line(case: Case) -> IngotLine:
    """The line with the first seed of the case's own whose ingot shows the wanted end."""
    seed = MILL_SEED + 10_000 * case["set"] + 100 * case["video"]
    while True:
        line = replace(_mill(), seed=seed)
        if _label(line) == case["label"]:
            return line
        seed += 1


def _label(line: IngotLine) -> Label:
    return next(moment.sights[-1].ingot.label for moment in timetable(line, 1) if moment.sights)


def _view(sequence: IngotSequence) -> IngotView:
    references = References(sequence.references["top"], sequence.references["bottom"])
    return IngotView(references, Box(*sequence.roi_crop), Box(*sequence.roi_centroid))


def _simulated(line: IngotLine) -> Iterator[tuple[IngotView, Any, str]]:
    """Frames in which the ingot lies on the line."""
    sequence = IngotSequence(line, 1)
    view = _view(sequence)
    for picture, told in sequence.frames:
        if told.present and told.state == "placed":
            yield view, picture, str(told.label)


@lru_cache(maxsize=1)
def _chosen_references() -> References:
    """From the first video of each kind, the first end that is found after the middle of its ingot's way."""
    top, bottom = (
        _end_of(_video_line({"set": 0, "video": video, "label": label})) for video, label in enumerate(LABELS)
    )
    return References(top, bottom)


def _end_of(line: IngotLine) -> Any:
    placed = [
        number
        for number, moment in enumerate(timetable(line, 1))
        if any(one.state == "placed" for one in moment.sights)
    ]
    for frame in placed[len(placed) // 2 :]:
        sequence = IngotSequence(line, 1)
        picture, _ = sequence.picture(frame)
        regions = ingot_regions(IngotSettings(), _view(sequence), picture)
        end, _ = make_finder(regions, IngotSettings().limits, picture).find(picture)
        if end is not None:
            return end_image(picture, end)
    raise ValueError("line: none of its ends is found")


def _verdict(end: Sequence[Any], classifier: str) -> str:
    if classifier == "single":
        return single(end[1])
    return dual(end[1], end[2]) if classifier == "dual" else str(end[3])


def _confusion(ends: Sequence[Sequence[Any]], classifier: str) -> Confusion:
    return Confusion.of((end[0], _verdict(end, classifier)) for end in ends)


def _classified(title: str, videos: Sequence[Sequence[Sequence[Any]]]) -> list[Table]:
    """Precision, recall and accuracy, and the counts that they come from; dissertation / here."""
    shares: list[tuple[str, ...]] = []
    counts: list[tuple[str, ...]] = []
    for name in CLASSIFIERS:
        ours = _confusion([end for video in videos for end in video], name)
        printed = PRINTED.get(name)
        both = _figures(None if printed is None else printed), _figures(ours)
        cells = (f"{number(theirs, '.4f')} / {number(value, '.4f')}" for theirs, value in zip(*both, strict=True))
        accuracy = mean_with_error([_confusion(video, name).accuracy for video in videos])
        shown = f"{name}, served" if name == "relief" else name
        shares.append((shown, *cells, accuracy))
        counts.append(
            (shown, *(f"{theirs} / {value}" for theirs, value in zip(_counts(printed), _counts(ours), strict=True)))
        )
    kinds = [f"{figure} of {kind}s" for kind in LABELS for figure in ("precision", "recall")]
    columns = ("", *kinds, "accuracy", "of a video, ± standard error")
    cells = ("", "tops as top", "tops as bottom", "bottoms as top", "bottoms as bottom")
    ends = sum(len(video) for video in videos)
    note = "The dissertation has no third classifier. A precision is '-' where no end was called so."
    return [
        Table(f"{title}: {ends} ends; dissertation / here", columns, shares, note),
        Table(
            f"Figures 6.17 and 6.21, {title.rsplit(', ', maxsplit=1)[-1]}; dissertation / here",
            cells,
            counts,
            note.split(". ", maxsplit=1)[0] + ".",
        ),
    ]


def _figures(counts: Confusion | None) -> Sequence[float | None]:
    if counts is None:
        return [None] * 5
    return [figure(kind) for kind in LABELS for figure in (counts.precision, counts.recall)] + [counts.accuracy]


def _counts(counts: Confusion | None) -> list[str]:
    if counts is None:
        return ["-"] * 4
    return [
        str(one) for one in (counts.top_as_top, counts.top_as_bottom, counts.bottom_as_top, counts.bottom_as_bottom)
    ]


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
