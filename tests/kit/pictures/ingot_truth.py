"""Reads a sequence of the ingot line, recorded or simulated, and counts what was found against the truth beside it."""

import csv
import json
from typing import NamedTuple

import cv2

from appliance.cameras.recording.picture_file import read_picture
from appliance.comparison.ends import Decided, matched
from appliance.comparison.files import EndTruth
from appliance.ingot.reader_setup import decision_rule, load_view, make_reader
from appliance.ingot.settings import IngotSettings
from appliance.simulation.ingots.conditions import ingot_sequence
from vision.ingot.classifiers.ssim import dual, single
from vision.ingot.end_finder import Box
from vision.ingot.orientation_reader import IngotView, References
from vision.ingot.sequential_decision import IngotFollower

SETTINGS = IngotSettings()
WHOLE_FRAMES = 20
CLASSIFIERS = ("single", "dual", SETTINGS.classifier)


class Sight(NamedTuple):
    """What is true of a frame."""

    present: bool
    label: str
    x: float
    y: float
    radius: float
    state: str


class Scene(NamedTuple):
    """A sequence: what is known of the camera, and frames as (picture, sight)."""

    view: IngotView
    frames: object


def recorded(folder, sequence):
    def frames():
        with (folder / sequence / "truth.csv").open(encoding="utf-8") as file:
            for row in csv.DictReader(file):
                picture = read_picture(folder / sequence / f"{int(row['frame']):06d}.jpg").shown
                numbers = (float(row[name] or "nan") for name in ("x", "y", "r"))
                yield picture, Sight(row["present"] == "1", row["label"], *numbers, row["state"])

    return Scene(load_view(folder), frames())


def simulated(seed, condition, ingots, later_step=1):
    """A simulated line; of the frames after the first WHOLE_FRAMES placed ones every later_step-th is drawn."""
    sequence = ingot_sequence(seed, condition, ingots)
    regions = Box(*sequence.roi_crop), Box(*sequence.roi_centroid)

    def frames():
        placed, number = 0, 0
        while True:
            try:
                picture, told = sequence.picture(number)
            except StopIteration:
                return
            sight = Sight(bool(told.present), told.label or "", told.x or 0, told.y or 0, told.r or 0, told.state)
            placed += sight.present and sight.state == "placed"
            number += later_step if placed > WHOLE_FRAMES else 1
            yield picture, sight

    return Scene(IngotView(References(sequence.references["top"], sequence.references["bottom"]), *regions), frames())


def write_references(folder, view):
    """References and regions as files, for commands."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, picture in (("top", view.references.top), ("bottom", view.references.bottom)):
        cv2.imwrite(str(folder / f"{name}.png"), picture)
    regions = {"roi_crop": list(view.crop), "roi_centroid": list(view.centroid)}
    (folder / "roi.json").write_text(json.dumps(regions), encoding="utf-8")


def follow(scene, settings=SETTINGS):
    """Counts of frames and ingots of one scene."""
    reader, sights, readings = None, [], []
    for picture, sight in scene.frames:
        reader = reader or make_reader(settings, scene.view, picture)
        sights.append(sight)
        readings.append(reader.read(picture))
    return counted(sights, readings, settings)


def counted(sights, readings, settings):
    """Counts of frames and ingots of readings of successive frames."""
    follower, decisions = IngotFollower(decision_rule(settings.decision)), []
    for frame, reading in enumerate(readings):
        decisions += follower.add(frame, reading)
    decisions += follower.end()
    truth = {frame: EndTruth(sight.present, sight.label, sight.state) for frame, sight in enumerate(sights)}
    decided = [Decided(one.orientation, one.first_frame, one.decided_frame) for one in decisions]
    ingots, strangers = matched(truth, decided)
    return {
        **_frames(sights, readings, settings.classifier),
        "ingots": [list(ingot) for ingot in ingots],
        "strangers": [[one.orientation, one.first_frame] for one in strangers],
    }


def _frames(sights, readings, classifier):
    pairs = list(zip(sights, readings, strict=True))
    placed = [(sight, reading) for sight, reading in pairs if sight.present and sight.state == "placed"]
    found = [(sight, reading) for sight, reading in placed if reading.present]
    elsewhere = [
        sight.state
        for sight, reading in pairs
        if reading.present and not sight.present and sight.state not in {"placed", "leaving"}
    ]
    verdicts = {name: {} for name in ("single", "dual", classifier)}
    for sight, reading in found:
        said = {
            "single": single(reading.ssim_top),
            "dual": dual(reading.ssim_top, reading.ssim_bottom),
            classifier: reading.orientation,
        }
        for name, verdict in said.items():
            key = f"{sight.label} as {verdict}"
            verdicts[name][key] = verdicts[name].get(key, 0) + 1
    return {"placed": len(placed), "found": len(found), "found_elsewhere": len(elsewhere), "verdicts": verdicts}
