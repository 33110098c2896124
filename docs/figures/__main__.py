"""Draws the figures of the documents: `make figures`. Needs the recordings (see HOTGAUGE_RECORDINGS)."""

import csv
import itertools
import json
import os
from pathlib import Path

import cv2
import edge_detectors
import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt

from appliance.cameras.recording.pairs import Recording
from appliance.cameras.recording.pictures import PictureRecording
from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.ingots.conditions import ingot_sequence
from appliance.simulation.sensor import Sensor, coded
from appliance.simulation.true_rig import default_rig
from appliance.sizing.stereo.calibrate_folder import calibrate_folder
from vision.calibration.rig import Rig
from vision.edges.profiles import sample_profiles
from vision.geometry.camera import Camera
from vision.light_planes import Decoder
from vision.sent_picture import SentPicture
from vision.sizing.region_grid import RegionGrid
from vision.sizing.tangent.limb_finder import LimbFinder

mpl.use("Agg")

FOLDER = Path(__file__).parent
RECORDINGS = Path(os.environ.get("HOTGAUGE_RECORDINGS", FOLDER.parents[2] / "shared" / "recordings"))
OFFSETS_PX = np.arange(-20.0, 12.0, 0.25)
NOISE_KERNEL = np.array([[1.0, -2.0, 1.0], [-2.0, 4.0, -2.0], [1.0, -2.0, 1.0]])  # blind to slopes; noise gain 6
RED = 2


def mill_pair(lit: bool):
    """A bar of the embedded mill, with or without its glow on the rollers."""
    bar = Bar(190.0)
    scene = Scene(default_rig(), 1, Sensor("gamma 2.2"), lit_by=bar if lit else None)
    return [SentPicture.of(coded(picture, "jpeg 4:4:4")) for picture in scene.pair(bar, 0)]


def mill_rig():
    """The embedded mill's cameras as they are."""
    left, right = (Camera(c.K, c.dist, c.R, c.t, c.image_size) for c in default_rig().cameras)
    empty = {name: np.empty((0, 2)) for name in ("left_low", "right_low", "left_high", "right_high")}
    return Rig(left, right, np.zeros((30, 30)), "gamma 2.2", (-250.0, 250.0), 0.0, 0.0, 200.0, 0.0, empty, 0.0)


def limb_profiles(pair, rig):
    """Mean red light across each limb, background to bar, over the bar's own light, one row per limb."""
    decoder = Decoder(rig.response)
    rows = []
    for view, (camera, picture) in enumerate(zip((rig.left, rig.right), pair, strict=True)):
        outline = RegionGrid(camera, rig.region_y_mm).bars(picture.shown, decoder.shown)[0]
        finder = LimbFinder(view, camera, decoder, rig.region_y_mm)
        limbs = [
            finder.finely(picture, finder.roughly(picture, line, side).line, side, rig.region_y_mm)
            for line, side in ((outline.left, -1), (outline.right, +1))
        ]
        middle = 0.5 * (limbs[0].point_px.mean(axis=0) + limbs[1].point_px.mean(axis=0))
        plane = decoder.planes(picture.coding, np.zeros(3), np.eye(3)[RED])[0]
        for limb in limbs:
            along = np.linalg.svd(limb.point_px - limb.point_px.mean(axis=0))[2][0]
            normal = np.array([-along[1], along[0]])
            normal *= np.sign((middle - limb.point_px.mean(axis=0)) @ normal)
            normals = np.tile(normal, (len(limb.point_px), 1))
            profile = sample_profiles(picture.measured, plane, limb.point_px, normals, OFFSETS_PX)
            mean = np.nanmean(profile, axis=0)
            rows.append(mean / mean[(OFFSETS_PX > 6) & (OFFSETS_PX < 11)].mean())
    return np.array(rows)


def noise(pair):
    """Level and standard deviation of the noise in code values of red, from differences that slopes cancel in."""
    red = np.concatenate([picture.shown[:, :, RED].ravel() for picture in pair])
    rough = np.concatenate(
        [np.abs(cv2.filter2D(p.shown[:, :, RED].astype(float), -1, NOISE_KERNEL)).ravel() for p in pair]
    )
    levels = np.arange(10, 245, 10)
    near = [np.abs(red.astype(int) - level) <= 4 for level in levels]
    return levels, [np.mean(rough[one]) * np.sqrt(np.pi / 2) / 6 if one.sum() > 3000 else np.nan for one in near]


def edge_profile():
    """Limbs and noise of the recording and of the mill side by side."""
    line_a = RECORDINGS / "line_a"
    _, left, right = next(iter(Recording(line_a / "scenes" / "s5_clean")))
    recorded = ("line_a, path-traced", (left, right), calibrate_folder(line_a).rig, "tab:blue")
    scenes = [
        recorded,
        ("mill, dark line", mill_pair(lit=False), mill_rig(), "tab:orange"),
        ("mill, lit rollers", mill_pair(lit=True), mill_rig(), "tab:red"),
    ]
    figure, (edge, grain) = plt.subplots(1, 2, figsize=(11, 4.2))
    for name, pair, rig, colour in scenes:
        for number, profile in enumerate(limb_profiles(pair, rig)):
            edge.plot(OFFSETS_PX, profile, color=colour, linewidth=1, label=name if number == 0 else None)
        grain.plot(*noise(pair), "o-", color=colour, markersize=3, label=name)
    edge.set(xlabel="across the limb, pixels (bar to the right)", ylabel="red light, share of the bar's")
    grain.set(xlabel="level, code values", ylabel="noise, code values", ylim=(0, None))
    for axes in (edge, grain):
        axes.grid(alpha=0.3)
        axes.legend()
    figure.tight_layout()
    figure.savefig(FOLDER / "edge_profile.png", dpi=80)


def at_half_way(frames, roi):
    """The crop region of the picture that is half way through the placed ones, each time an ingot is placed."""
    left, top, width, height = roi
    for state, group in itertools.groupby(frames, key=lambda frame: frame[1]):
        placed = [picture for picture, _ in group]
        if state == "placed":
            yield placed[len(placed) // 2][top : top + height, left : left + width]


def recorded_ingots():
    """One picture of each ingot of the path-traced recording."""
    line = RECORDINGS / "ingot_line"
    roi = json.loads((line / "roi.json").read_text())["roi_crop"]
    for folder in sorted(line.glob("seq*")):
        states = [row["state"] for row in csv.DictReader((folder / "truth.csv").read_text().splitlines())]
        pictures = (picture.shown for _, picture in PictureRecording(folder))
        yield from at_half_way(zip(pictures, states, strict=True), roi)


def mill_ingots(seeds):
    """One picture of each of two ingots of every seed."""
    for seed in seeds:
        sequence = ingot_sequence(seed)
        yield from at_half_way(((picture, truth.state) for picture, truth in sequence.frames), sequence.roi_crop)


def ingot_strip():
    """Ingots of the recording above, of five simulated lines below."""
    recorded, simulated = list(recorded_ingots()), list(mill_ingots(range(1, 6)))
    figure, axes = plt.subplots(3, 5, figsize=(11, 8))
    for place, picture in zip(axes.flat, recorded + simulated, strict=True):
        place.imshow(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB))
        place.set_axis_off()
    axes[0, 0].set_title("ingot_line, path-traced", loc="left", fontsize=9)
    axes[1, 0].set_title("mill, two ingots of each of five lines", loc="left", fontsize=9)
    figure.tight_layout()
    figure.savefig(FOLDER / "ingots.png", dpi=70)


if __name__ == "__main__":
    edge_profile()
    ingot_strip()
    edge_detectors.save(FOLDER)
