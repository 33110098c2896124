"""Folders of pictures of bars on the simulated mill's line, for cameras that show folders, and their rig."""

import cv2

from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.sensor import Sensor
from appliance.simulation.true_rig import default_rig
from appliance.sizing.stereo.rig_file import save_rig

SEED = 1
RED = 2


def write_bars(folder, diameters_mm):
    """Folders `left` and `right` with a picture for each diameter, as a monochrome camera that sees red has it.

    None in place of a diameter is the line without a bar.
    """
    scene = Scene(default_rig(), SEED, Sensor())
    for number, diameter_mm in enumerate(diameters_mm):
        bar = None if diameter_mm is None else Bar(diameter_mm=diameter_mm, offset_mm=5.0, yaw_deg=0.5)
        for side, picture in zip(("left", "right"), scene.pair(bar, number), strict=True):
            (folder / side).mkdir(parents=True, exist_ok=True)
            cv2.imwrite(str(folder / side / f"{number:02}.png"), picture[:, :, RED])


def write_rig(path):
    """The rig file of the mill's cameras."""
    save_rig(mill_rig(MillSource(seed=SEED, rate_hz=0)), path)
