"""Sequences of an ingot line: pictures, what is true of each, and what is known of the line before."""

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np

from appliance.simulation.ingots.faces import LABELS, Label
from appliance.simulation.ingots.line import IngotLine
from appliance.simulation.ingots.solid import Pose, outline_px
from appliance.simulation.ingots.timetable import Moment, Sight, timetable
from appliance.simulation.ingots.truth import Truth, truth
from appliance.simulation.ingots.view import LineView, Picture

REFERENCE_PX = 64
REFERENCE_PLACE = 0.4  # of the way to the rolls


class IngotSequence:
    """Pictures of an ingot line, one after the other, what is true of each, and what is known of the line before.

    Parameters
    ----------
    line : IngotLine
    ingots : int or None
        How many pass; None: without end.

    Attributes
    ----------
    line : IngotLine
    references : dict
        `top` and `bottom`: squares of 64 x 64 pixels around the end of ingots that are in no sequence.
    roi_crop, roi_centroid : tuple of int
        x, y, width, height, pixels.
    radius_px : tuple of float
        Half widths of the end where ingots are set down and where they leave.
    """

    def __init__(self, line: IngotLine, ingots: int | None = None) -> None:
        self.line = line
        as_set_up = replace(line, turned_deg=(0.0, 0.0, 0.0), gain=1.0)
        before = LineView(as_set_up)
        changed = (line.turned_deg, line.gain) != (as_set_up.turned_deg, as_set_up.gain)
        self._view = LineView(line) if changed else before
        self._moments = enumerate(timetable(line, ingots))
        self.references: dict[Label, Picture] = {
            label: _reference(before, number, label) for number, label in enumerate(LABELS)
        }
        self.roi_crop = line.roi_crop()
        self.roi_centroid = line.roi_centroid()
        self.radius_px = line.radius_px()

    @property
    def frames(self) -> Iterator[tuple[Picture, Truth]]:
        """The frames that are left: pictures of uint8, shape (rows, columns, 3), blue-green-red, and their truth."""
        return ((decoded(jpeg), told) for jpeg, told in self.jpeg_frames)

    @property
    def jpeg_frames(self) -> Iterator[tuple[bytes, Truth]]:
        """The frames that are left: pictures as the camera sends them, as JPEG, and their truth."""
        return (self._drawn(frame, moment) for frame, moment in self._moments)

    def picture(self, frame: int) -> tuple[Picture, Truth]:
        """A frame that is left, without drawing those before it; raises `StopIteration` after the last."""
        number, moment = next(self._moments)
        while number < frame:
            number, moment = next(self._moments)
        jpeg, told = self._drawn(number, moment)
        return decoded(jpeg), told

    def _drawn(self, frame: int, moment: Moment) -> tuple[bytes, Truth]:
        return self._view.jpeg(self._view.exposed(moment, frame)), truth(self._view, moment, frame)


def _reference(view: LineView, number: int, label: Label) -> Picture:
    """The bottom square of a typical ingot on its way to the rolls."""
    line = view.line
    ingot = line.typical_ingot(label, np.random.default_rng([line.seed, 0x7265, number]))
    pose = Pose((0.0, REFERENCE_PLACE * line.travel_mm, ingot.radius_mm))
    picture = decoded(view.jpeg(view.exposed(Moment((Sight(ingot, pose, "placed"),)), number)))
    outline = outline_px(view.camera, ingot, pose)
    (left, _), (right, bottom) = (np.rint(edge(axis=0)).astype(int) for edge in (outline.min, outline.max))
    square = picture[bottom - (right - left) : bottom + 1, left : right + 1]
    return np.asarray(cv2.resize(square, (REFERENCE_PX, REFERENCE_PX), interpolation=cv2.INTER_AREA), np.uint8)


def decoded(jpeg: bytes) -> Picture:
    """A picture from its JPEG, blue-green-red."""
    return np.asarray(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR), np.uint8)
