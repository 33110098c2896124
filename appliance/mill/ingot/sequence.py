"""Pictures of an ingot line, frame after frame, with what is true of each."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.mill.bars import levels
from appliance.mill.ingot import hall
from appliance.mill.ingot.faces import LABELS, Label
from appliance.mill.ingot.line import Box, IngotLine
from appliance.mill.ingot.solid import Seen, end_circle_px, outline_px, rim_mm, see, window
from appliance.mill.ingot.timetable import Glare, Moment, Sight, State, timetable
from appliance.mill.rig import TrueCamera, nudged
from appliance.mill.sensor import Light, NoiseStock, encode

Picture = NDArray[np.uint8]

REFERENCE_PX = 64
MARGIN_PX = 24  # of an ingot's window, for what spreads from it
BRIGHTEST = 6.0  # light over full scale that the table of codes reaches
TABLE_STEPS = 1 << 15
OVEREXPOSED_PART = 0.1  # of the end whose red is clipped
BORDERS_PART = 0.5  # of the ingot's red light that a glare beside it has
TONGS_LIGHT = np.array([0.012, 0.014, 0.02], np.float32)
GLARE_COLOURS = np.array([[1.05, 1.0, 0.97], [0.25, 0.6, 1.05]], np.float32)  # white, warm


class Truth(NamedTuple):
    """A row of `truth.csv`; `None` is an empty field.

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
        1 when glare borders the ingot.
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


@dataclass(frozen=True, slots=True, eq=False)
class IngotSequence:
    """Pictures and truth of an ingot line, and what is known of it before.

    Attributes
    ----------
    line : IngotLine
    frames : iterator of (Picture, Truth)
        Blue-green-red pictures of uint8, shape (rows, columns, 3), as they come back from JPEG.
    references : dict
        `top` and `bottom`: squares of 64 x 64 pixels around the end of ingots that are in no sequence.
    roi_crop, roi_centroid : tuple of int
        x, y, width, height, pixels.
    radius_px : tuple of float
        Half widths of the end where ingots are set down and where they leave.
    """

    line: IngotLine
    frames: Iterator[tuple[Picture, Truth]]
    references: dict[Label, Picture]
    roi_crop: Box
    roi_centroid: Box
    radius_px: tuple[float, float]


def sequence_of(line: IngotLine, ingots: int | None = None) -> IngotSequence:
    """Sequence of a line that some ingots pass; without a number it has no end."""
    view = LineView(line)
    frames = (
        (view.coded(view.exposed(moment, frame)), view.truth(moment, frame))
        for frame, moment in enumerate(timetable(line, ingots))
    )
    return IngotSequence(line, frames, references(line), line.roi_crop(), line.roi_centroid(), line.radius_px())


def references(line: IngotLine) -> dict[Label, Picture]:
    """References of a line: the bottom squares of a typical top and bottom, half way to the rolls."""
    as_set_up = replace(line, turned_deg=(0.0, 0.0, 0.0), gain=1.0)
    view = LineView(as_set_up)
    squares: dict[Label, Picture] = {}
    for number, label in enumerate(LABELS):
        ingot = line.typical_ingot(label, np.random.default_rng([line.seed, 0x7265, number]))
        pose = replace(line.place(0.4 * line.travel_mm), end_mm=(0.0, 0.4 * line.travel_mm, ingot.radius_mm))
        picture = view.coded(view.exposed(Moment((Sight(ingot, pose, "placed"),)), number))
        outline = outline_px(line.camera, ingot, pose)
        (left, _), (right, bottom) = np.rint(outline.min(axis=0)).astype(int), np.rint(outline.max(axis=0)).astype(int)
        square = picture[bottom - (right - left) : bottom + 1, left : right + 1]
        squares[label] = np.asarray(
            cv2.resize(square, (REFERENCE_PX, REFERENCE_PX), interpolation=cv2.INTER_AREA), np.uint8
        )
    return squares


class LineView:
    """Draws the moments of a line; what stands still is drawn once.

    Parameters
    ----------
    line : IngotLine
    """

    def __init__(self, line: IngotLine) -> None:
        self._line = line
        self.camera: TrueCamera = nudged(line.camera, line.turned_deg)
        self._crop = line.roi_crop()
        self._rays = self.camera.rays(self.camera.pixel_grid()).astype(np.float32)
        rng = np.random.default_rng([line.seed, 0x6861])
        self._hall = hall.draw(
            self.camera, self._rays, rng, radius_mm=line.radius_mm, brightness=line.brightness, blur=line.blur
        )
        self._codes = _Codes(line)
        self._noise = NoiseStock(self._rays.shape, line.seed)
        self._still: dict[float, tuple[Light, Light]] = {}
        self._glares: dict[Glare, tuple[slice, slice, Light]] = {}

    def exposed(self, moment: Moment, frame: int) -> Picture:
        """8-bit picture before its coding, blue-green-red; the frame's number chooses the noise."""
        gain = self._line.gain * moment.exposure
        codes, spread = (still.copy() for still in self._still_codes(gain))
        for rows, columns in self._touched(moment):
            light = self._light(moment, rows, columns)
            codes[rows, columns], spread[rows, columns] = self._codes.of(light * np.float32(gain))
        start = int(np.random.default_rng([self._line.seed, 0x6E73, frame]).integers(NoiseStock.EXTRA))
        spread *= self._noise.cut(start)
        return np.asarray(cv2.add(codes, spread, dtype=cv2.CV_8U), np.uint8)

    def coded(self, picture: Picture) -> Picture:
        """A picture as it comes back from the camera's JPEG."""
        return np.asarray(cv2.imdecode(np.frombuffer(self.jpeg(picture), np.uint8), cv2.IMREAD_COLOR), np.uint8)

    def jpeg(self, picture: Picture) -> bytes:
        """A picture as JPEG with halved colour resolution, as cameras send it."""
        return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, self._line.quality])[1].tobytes()

    def truth(self, moment: Moment, frame: int) -> Truth:
        """What is true of a moment."""
        if not moment.sights:
            return Truth(frame, 0, None, None, None, None, "empty", 0, 0)
        on_line = [sight for sight in moment.sights if sight.state in {"placed", "leaving"}]
        sight = (on_line or list(moment.sights))[-1]
        if not on_line or not self._is_inside(sight):
            return Truth(frame, 0, None, None, None, None, sight.state, 0, 0)
        x, y, radius = (round(value, 2) for value in end_circle_px(self.camera, sight.ingot, sight.pose))
        touch, over = self._borders(moment, sight), self._is_overexposed(moment, sight)
        return Truth(frame, 1, sight.ingot.label, x, y, radius, sight.state, int(touch), int(over))

    def _is_inside(self, sight: Sight) -> bool:
        rim = self.camera.project(rim_mm(sight.ingot, sight.pose))
        left, top, width, height = self._crop
        low, high = np.array([left, top]), np.array([left + width - 1, top + height - 1])
        return bool(np.all((rim >= low) & (rim <= high)))

    def _still_codes(self, gain: float) -> tuple[Light, Light]:
        if gain not in self._still:
            if len(self._still) > 2:
                self._still.pop(next(iter(self._still)))
            self._still[gain] = self._codes.of((self._hall.light + np.float32(self._line.veil)) * np.float32(gain))
        return self._still[gain]

    def _touched(self, moment: Moment) -> list[tuple[slice, slice]]:
        """Windows of the picture in which something is not as on the empty line, without overlap."""
        windows = [self._glare(moment.glare)[:2]] if moment.glare else []
        windows += [self._window(sight) for sight in moment.sights if not self._is_behind(sight)]
        return _merged([(rows, columns) for rows, columns in windows if rows.stop > rows.start])

    def _is_behind(self, sight: Sight) -> bool:
        return bool(np.isnan(outline_px(self.camera, sight.ingot, sight.pose)).any())

    def _window(self, sight: Sight) -> tuple[slice, slice]:
        outline = outline_px(self.camera, sight.ingot, sight.pose)
        radius_px = end_circle_px(self.camera, sight.ingot, sight.pose)[2]
        rows, columns = window(outline, 1.5 * radius_px, self.camera.image_size)
        return (slice(0, rows.stop), columns) if np.isfinite(sight.tongs_mm) else (rows, columns)

    def _light(self, moment: Moment, rows: slice, columns: slice) -> Light:
        """Linear light in a window, blue-green-red, before the exposure."""
        light = self._hall.light[rows, columns].copy()
        if moment.glare:
            glare_rows, glare_columns, glare = self._glare(moment.glare)
            within = slice(glare_rows.start - rows.start, glare_rows.stop - rows.start)
            if within.start >= 0 and glare_rows.stop <= rows.stop and glare_columns.start >= columns.start:
                light[within, glare_columns.start - columns.start : glare_columns.stop - columns.start] += glare
        for sight in moment.sights:
            self._add_glow(light, sight, rows, columns)
        for sight in moment.sights:
            self._add_ingot(light, sight, rows, columns)
            if np.isfinite(sight.tongs_mm):
                self._add_tongs(light, sight, rows, columns)
        light += np.float32(self._line.veil)
        return light

    def _colour(self, sight: Sight) -> Light:
        """Linear light of an ingot of relative light 1."""
        hot = levels(sight.ingot.temperature_c) * sight.heating
        return (hot * self._line.white + 0.01 * self._line.brightness).astype(np.float32)

    def _add_ingot(self, light: Light, sight: Sight, rows: slice, columns: slice) -> None:
        seen = see(self.camera, self._rays, sight.ingot, sight.pose, MARGIN_PX)
        if seen is None or not _lies_in(seen, rows, columns):
            return
        blur, bloom = self._line.blur, self._line.bloom
        planes = np.stack([seen.coverage, seen.light], axis=2)
        sharp = cv2.GaussianBlur(planes, (0, 0), blur.core_px, borderType=cv2.BORDER_REPLICATE)
        small = cv2.resize(seen.light, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
        wide = cv2.resize(cv2.GaussianBlur(small, (0, 0), 2.0), seen.light.shape[::-1], interpolation=cv2.INTER_LINEAR)
        part = light[
            seen.rows.start - rows.start : seen.rows.stop - rows.start,
            seen.columns.start - columns.start : seen.columns.stop - columns.start,
        ]
        part *= 1 - sharp[..., :1]
        relative = np.float32(1 - bloom) * sharp[..., 1] + np.float32(bloom) * wide
        part += relative[..., None] * self._colour(sight)

    def _add_glow(self, light: Light, sight: Sight, rows: slice, columns: slice) -> None:
        """The line around an ingot reflects its glow, and lies in its shadow where both meet."""
        x, y = self._hall.x_mm[rows, columns][::4, ::4], self._hall.y_mm[rows, columns][::4, ::4]
        radius = sight.ingot.radius_mm
        end_x, end_y, end_z = sight.pose.end_mm
        aside = (x - end_x) / radius
        ahead = np.maximum(y - end_y, 0) / radius + np.maximum(end_y - sight.ingot.length_mm - y, 0) / radius
        height = max(0.0, end_z / radius - 1)
        square = aside**2 + ahead**2 + height**2
        glow = 0.35 / (1 + square) ** 1.5
        contact = np.exp(-(aside**2) - (3 * ahead) ** 2 - (2 * height) ** 2)
        size = light.shape[1::-1]
        glow, contact = (
            cv2.resize(p.astype(np.float32), size, interpolation=cv2.INTER_LINEAR) for p in (glow, contact)
        )
        light *= (1 - np.float32(0.7) * contact)[..., None]
        glow *= self._hall.sheen[rows, columns] * (1 - np.float32(0.8) * contact)
        light += glow[..., None] * self._colour(sight)

    def _add_tongs(self, light: Light, sight: Sight, rows: slice, columns: slice) -> None:
        """The crane's tongs in front of an ingot: two bent arms that meet above it."""
        axis, across, _ = sight.pose.axes
        radius = sight.ingot.radius_mm
        grip = np.array(sight.pose.end_mm) + 0.45 * sight.ingot.length_mm * axis
        up = np.array([0.0, 0.0, 1.0])
        grip = grip + sight.tongs_mm * up + radius * 0.1 * up
        opening = 1.0 if sight.tongs_mm == 0 else 1.5
        hinge = grip + 2.6 * radius * up
        lines = [np.stack([hinge, hinge + 30 * radius * up])]
        for side in (-1, 1):
            arm = opening * radius * side * across
            lines.append(
                np.stack(
                    [
                        hinge,
                        grip + 1.25 * arm + 1.3 * radius * up,
                        grip + 1.2 * arm,
                        grip + 0.8 * arm - 0.15 * radius * up,
                    ]
                )
            )
        drawn = np.zeros(light.shape[:2], np.uint8)
        thickness = max(2, round(0.16 * end_circle_px(self.camera, sight.ingot, sight.pose)[2]))
        offset = np.array([columns.start, rows.start])
        for line in lines:
            pixels = self.camera.project(line) - offset
            if not np.isnan(pixels).any():
                points = np.rint(np.clip(pixels, -4000, 4000) * 8).astype(np.int32)
                cv2.polylines(drawn, [points], False, 255, thickness, cv2.LINE_AA, shift=3)
        covered = cv2.GaussianBlur(drawn, (0, 0), self._line.blur.core_px)[..., None] * np.float32(1 / 255)
        light *= 1 - covered
        light += covered * (TONGS_LIGHT * np.float32(self._line.brightness) + np.float32(0.02) * self._colour(sight))

    def _glare(self, glare: Glare) -> tuple[slice, slice, Light]:
        """Window and light of a glare: a patch with a ragged outline, streaked along the rollers."""
        if glare not in self._glares:
            rng = np.random.default_rng([glare.seed])
            (x, y), (width, depth) = glare.place_mm, glare.size_mm
            aside, along = (self._hall.x_mm - x) / width, (self._hall.y_mm - y) / depth
            near = np.flatnonzero((aside**2 + along**2 < 4).any(axis=1))
            across = np.flatnonzero((aside**2 + along**2 < 4).any(axis=0))
            if not len(near):
                self._glares[glare] = slice(0, 0), slice(0, 0), np.zeros((0, 0, 3), np.float32)
                return self._glares[glare]
            rows, columns = (slice(int(hit[0]), int(hit[-1]) + 1) for hit in (near, across))
            shape = rows.stop - rows.start, columns.stop - columns.start
            streaks = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), sigmaX=12, sigmaY=1.5)
            streaks = streaks / max(1e-6, float(np.std(streaks)))
            place = np.hypot(aside[rows, columns], along[rows, columns]) + np.float32(0.15) * streaks
            sheen = np.minimum(self._hall.sheen[rows, columns], 1)
            patch = (
                np.float32(glare.level)
                / (1 + np.exp((place - 1) / np.float32(0.08)))
                * (np.float32(0.6) + np.float32(0.4) * sheen)
            )
            patch = np.where(aside[rows, columns] ** 2 + along[rows, columns] ** 2 < 4, patch, 0).astype(np.float32)
            patch = cv2.GaussianBlur(patch, (0, 0), self._line.blur.core_px)
            colour = GLARE_COLOURS[0] + np.float32(glare.warmth) * (GLARE_COLOURS[1] - GLARE_COLOURS[0])
            self._glares[glare] = rows, columns, patch[..., None] * colour
        return self._glares[glare]

    def _borders(self, moment: Moment, sight: Sight) -> bool:
        """Whether light that is nearly as bright as the ingot in red lies just outside its outline."""
        seen = see(self.camera, self._rays, sight.ingot, sight.pose, MARGIN_PX)
        if moment.glare is None or seen is None:
            return False
        glare = np.zeros(self._rays.shape[:2], np.float32)
        rows, columns, light = self._glare(moment.glare)
        glare[rows, columns] = light[..., 2]
        solid = (seen.coverage > 0.5).astype(np.uint8)
        ring = cv2.dilate(solid, np.ones((7, 7), np.uint8)) > solid
        bright = glare[seen.rows, seen.columns] > BORDERS_PART * self._colour(sight)[2]
        return bool(np.count_nonzero(ring & bright) >= 3)

    def _is_overexposed(self, moment: Moment, sight: Sight) -> bool:
        seen = see(self.camera, self._rays, sight.ingot, sight.pose, MARGIN_PX)
        if seen is None:
            return False
        gain = self._line.gain * moment.exposure
        red = seen.light * self._colour(sight)[2] + self._line.veil
        end = seen.face > 0.99
        return int(np.count_nonzero(end & (red * gain > 1))) > OVEREXPOSED_PART * int(np.count_nonzero(end))


def _lies_in(seen: Seen, rows: slice, columns: slice) -> bool:
    return (
        seen.rows.start >= rows.start
        and seen.rows.stop <= rows.stop
        and seen.columns.start >= columns.start
        and seen.columns.stop <= columns.stop
    )


def _merged(windows: list[tuple[slice, slice]]) -> list[tuple[slice, slice]]:
    """Windows that cover the same, those that overlap made one."""
    merged: list[tuple[slice, slice]] = []
    for rows, columns in windows:
        joined = (rows, columns)
        for other in list(merged):
            if _overlap(joined[0], other[0]) and _overlap(joined[1], other[1]):
                merged.remove(other)
                joined = (_hull(joined[0], other[0]), _hull(joined[1], other[1]))
        merged.append(joined)
    return merged if len(merged) == len(windows) else _merged(merged)


def _overlap(a: slice, b: slice) -> bool:
    return a.start < b.stop and b.start < a.stop


def _hull(a: slice, b: slice) -> slice:
    return slice(min(a.start, b.start), max(a.stop, b.stop))


class _Codes:
    """8-bit values, not rounded, and their noise, over linear light; both go on beyond full scale."""

    def __init__(self, line: IngotLine) -> None:
        light = np.linspace(0, BRIGHTEST, TABLE_STEPS + 1)
        code = encode(np.minimum(light, 1.0), line.sensor.response)
        slope = (1 - encode(np.array([0.99]), line.sensor.response)[0]) / 0.01
        code = 255 * (code + slope * np.maximum(light - 1, 0))
        spread = np.gradient(code, light) * line.sensor.noise(light.astype(np.float32))
        self._codes, self._spread = code.astype(np.float32), spread.astype(np.float32)

    def of(self, light: Light) -> tuple[Light, Light]:
        """Values and the standard deviations of their noise."""
        place = (np.minimum(light, np.float32(BRIGHTEST)) * np.float32(TABLE_STEPS / BRIGHTEST)).astype(np.int32)
        return np.take(self._codes, place), np.take(self._spread, place)


def first_frames(sequence: IngotSequence, frames: int) -> Iterator[tuple[Picture, Truth]]:
    """The first frames of a sequence."""
    return itertools.islice(sequence.frames, frames)
