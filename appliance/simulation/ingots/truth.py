"""What is true of a frame of the ingot line: the row beside its picture."""

from typing import NamedTuple

import cv2
import numpy as np

from appliance.simulation.ingots.faces import Label
from appliance.simulation.ingots.line import Box
from appliance.simulation.ingots.solid import end_circle_px, rim_mm
from appliance.simulation.ingots.timetable import Moment, Sight, State
from appliance.simulation.ingots.view import LineView

OVEREXPOSED_PART = 0.1  # of the end whose red is clipped
BORDERING_PART = 0.5  # of the ingot's red light that a glare beside it has
BORDER_PX = 3
BORDERING_PIXELS = 3


class Truth(NamedTuple):
    """A row of `truth.csv`; None is an empty field.

    Attributes
    ----------
    frame : int
    present : int
        1 when an ingot is on the line and its whole end lies inside the crop region.
    label : str or None
        Which end faces the camera.
    x, y, r : float or None
        Centre of the end, and half its width, pixels.
    state : str
        empty, hanging, lowering, placed or leaving.
    touch : int
        1 when a glare borders the ingot.
    over : int
        1 when red is clipped on more than a tenth of the end.
    """

    frame: int
    present: int
    label: Label | None
    x: float | None
    y: float | None
    r: float | None
    state: State
    touch: int
    over: int


def truth(view: LineView, moment: Moment, frame: int) -> Truth:
    """What is true of a moment: of the ingot on the line that is nearest to the rolls, if there is one."""
    if not moment.sights:
        return Truth(frame, 0, None, None, None, None, "empty", 0, 0)
    on_line = [sight for sight in moment.sights if sight.state in {"placed", "leaving"}]
    sight = (on_line or list(moment.sights))[-1]
    if not on_line or not _is_inside(view, sight, view.line.roi_crop()):
        return Truth(frame, 0, None, None, None, None, sight.state, 0, 0)
    x, y, radius = (round(value, 2) for value in end_circle_px(view.camera, sight.ingot, sight.pose))
    touch, over = _is_bordered(view, moment, sight), _is_overexposed(view, moment, sight)
    return Truth(frame, 1, sight.ingot.label, x, y, radius, sight.state, int(touch), int(over))


def _is_inside(view: LineView, sight: Sight, box: Box) -> bool:
    rim = view.camera.project(rim_mm(sight.ingot, sight.pose))
    left, top, width, height = box
    low, high = np.array([left, top]), np.array([left + width - 1, top + height - 1])
    return bool(np.all((rim >= low) & (rim <= high)))


def _is_bordered(view: LineView, moment: Moment, sight: Sight) -> bool:
    """Whether light that is half as bright as the ingot in red lies just outside its outline."""
    patch, seen = view.patch(moment), view.seen(sight)
    if patch is None or seen is None:
        return False
    columns, rows = view.camera.image_size
    glare = np.zeros((rows, columns), np.float32)
    glare[patch.rows, patch.columns] = patch.light[..., 2]
    solid = (seen.coverage > 0.5).astype(np.uint8)
    width = 2 * BORDER_PX + 1
    border = cv2.dilate(solid, np.ones((width, width), np.uint8)) > solid
    bright = glare[seen.rows, seen.columns] > BORDERING_PART * view.colour(sight)[2]
    return int(np.count_nonzero(border & bright)) >= BORDERING_PIXELS


def _is_overexposed(view: LineView, moment: Moment, sight: Sight) -> bool:
    seen = view.seen(sight)
    if seen is None:
        return False
    red = view.line.gain * moment.exposure * (seen.light * view.colour(sight)[2] + view.line.veil)
    end = seen.face > 0.99
    return int(np.count_nonzero(end & (red > 1))) > OVEREXPOSED_PART * int(np.count_nonzero(end))
