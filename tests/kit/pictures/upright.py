"""A bar's picture turned upright, with the true place of its limbs in every row: for judging edges."""

import json
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from appliance.simulation.true_rig import TrueCamera

MARGIN_PX = 60
BORDER_ROWS = 16  # above and below what is judged: edges there have all their neighbours
JUDGED = slice(BORDER_ROWS, -BORDER_ROWS)
COARSE_PX = 8
CLIPPED = 0.02  # part of a picture at full scale from which on its channel is not used


class Axis(NamedTuple):
    """A straight round bar's."""

    point_mm: np.ndarray
    direction: np.ndarray
    radius_mm: float


@dataclass(frozen=True)
class Upright:
    """The measuring region, one pixel to a pixel.

    `colour`: float32 RGB, (rows, columns, 3); `grey`: its brightest channel that is not clipped; `limbs_px`: columns of
    the left and right limb in the `JUDGED` rows.
    """

    colour: np.ndarray
    grey: np.ndarray
    limbs_px: np.ndarray


def upright(picture, camera: TrueCamera, axis: Axis, region_y_mm) -> Upright:
    """A picture, BGR, around the measuring region of a bar."""
    nearer, further = camera.project(axis.point_mm + np.outer(region_y_mm, axis.direction))
    along = (nearer - further) / np.linalg.norm(nearer - further)
    across = np.array([-along[1], along[0]]) * -1
    distance_mm = np.linalg.norm(camera.centre_mm - axis.point_mm)
    half_width = int(1.1 * axis.radius_mm * camera.K[0, 0] / distance_mm) + MARGIN_PX
    half_height = int(np.linalg.norm(nearer - further) / 2) + BORDER_ROWS
    x, y = np.meshgrid(np.arange(-half_width, half_width + 1.0), np.arange(-half_height, half_height + 1.0))
    places = (nearer + further) / 2 + x[..., None] * across + y[..., None] * along
    places = np.clip(places, 0, np.array(camera.image_size) - 1)
    unclipped = [channel for channel in range(3) if np.mean(picture[..., channel] >= 254) < CLIPPED]
    channel = max(unclipped, key=lambda channel: picture[..., channel].mean())
    x, y = np.moveaxis(places.astype(np.float32), -1, 0)
    image = cv2.remap(picture, x, y, cv2.INTER_LINEAR).astype(np.float32) / 255
    passing = _passing_mm(camera, places[:, ::COARSE_PX], axis)
    columns = np.arange(places.shape[1])[::COARSE_PX].astype(float)
    if passing[0, 0] > passing[0, -1]:
        passing = -passing
    limbs = [[np.interp(side * axis.radius_mm, row, columns) for row in passing] for side in (-1, 1)]
    colour = np.ascontiguousarray(image[..., ::-1])
    return Upright(colour, image[..., channel].copy(), np.array(limbs)[:, JUDGED])


def _passing_mm(camera, places, axis):
    """Signed distance at which the light of pixels passes the axis."""
    normal = np.cross(camera.rays(places), axis.direction)
    return normal @ (axis.point_mm - camera.centre_mm) / np.linalg.norm(normal, axis=-1)


def recorded(folder, scene, frame, side):
    """An upright bar of a recording with the renderer's own truth."""
    rig = json.loads((folder / "truth_rig.json").read_text())
    truth = json.loads((folder / "scenes" / scene / "truth.json").read_text())
    of_camera = {key: np.array(value) for key, value in rig["cameras"][side].items()}
    camera = TrueCamera(**of_camera, image_size=tuple(rig["image_size"]))
    bar = truth["frames"][frame]
    axis = Axis(np.array(bar["axis_point_mm"]), np.array(bar["axis_direction"]), truth["diameter_mm"] / 2)
    picture = cv2.imread(str(folder / "scenes" / scene / side / f"{bar['frame']}.jpg"), cv2.IMREAD_COLOR)
    return upright(picture, camera, axis, rig["measure_y_mm"])


def rendered(setup, pair, side):
    """An upright bar of the mill."""
    camera, picture = (setup.rig.left, pair[0]) if side == "left" else (setup.rig.right, pair[1])
    bar = setup.bars[0]
    axis = Axis(bar.axis_point_mm, bar.axis_direction, bar.diameter_mm / 2)
    return upright(picture, camera, axis, setup.rig.region_y_mm)
