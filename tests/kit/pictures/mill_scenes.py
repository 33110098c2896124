"""Pictures of the simulated mill with what the gauge would know of the rig if its calibration were perfect."""

from pathlib import Path

import cv2
import numpy as np

from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.simulation.bars.bars import Bar
from appliance.simulation.true_rig import TrueRig
from appliance.sizing.stereo.rig_file import save_rig
from vision.calibration.rig import Rig
from vision.geometry.camera import Camera


def perfect_rig(true_rig: TrueRig, response: str = "srgb") -> Rig:
    left, right = (Camera(camera.K, camera.dist, camera.R, camera.t, camera.image_size) for camera in true_rig.cameras)
    return Rig(
        left=left,
        right=right,
        covariance=np.zeros((30, 30)),
        response=response,
        region_y_mm=(-250.0, 250.0),
        square_relative_u=0.0,
        low_mm=0.0,
        high_mm=200.0,
        height_u_mm=0.0,
        boards={},
        residual_px=0.0,
    )


def random_bar(rng: np.random.Generator) -> Bar:
    return Bar(
        diameter_mm=rng.uniform(80, 300),
        offset_mm=rng.uniform(-50, 50),
        yaw_deg=rng.uniform(-1.5, 1.5),
        temperature_c=rng.uniform(1050, 1100),
        warm_side_deg=rng.uniform(30, 150),
    )


def write_line(folder: Path, seed: int, frames: int) -> None:
    """A short recording of the mill in `scene` and the rig that belongs to it in `rig.json`."""
    source = MillSource(seed=seed, rate_hz=0)
    for side in ("left", "right"):
        (folder / "scene" / side).mkdir(parents=True)
    with source:
        for number in range(frames):
            pair = source.next(1)
            for side, picture in (("left", pair.left), ("right", pair.right)):
                cv2.imwrite(str(folder / "scene" / side / f"{number:06d}.png"), picture)
    save_rig(mill_rig(source), folder / "rig.json")
