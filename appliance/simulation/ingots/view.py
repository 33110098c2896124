"""Draws the moments of an ingot line: what stands still once, what moves in windows of the picture."""

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars.bars import levels
from appliance.simulation.ingots import glare, hall, tongs
from appliance.simulation.ingots.line import IngotLine
from appliance.simulation.ingots.solid import Seen, outline_px, see, window
from appliance.simulation.ingots.timetable import Moment, Sight
from appliance.simulation.response import encode
from appliance.simulation.sensor import Light, NoiseStock
from appliance.simulation.true_rig import nudged

Picture = NDArray[np.uint8]
Window = tuple[slice, slice]  # rows, columns

MARGIN_PX = 24  # of an ingot's window, for what spreads from it
GLOWING = 1.5  # reach of an ingot's glow on the line, in its radii
GAINS_KEPT = 3
BRIGHTEST = 6.0  # light over full scale that the table of codes reaches
TABLE_STEPS = 1 << 15


class LineView:
    """What the camera of a line sees.

    Parameters
    ----------
    line : IngotLine

    Attributes
    ----------
    line : IngotLine
    camera : TrueCamera
        As it stands now.
    """

    def __init__(self, line: IngotLine) -> None:
        self.line = line
        self.camera = nudged(line.camera, line.turned_deg)
        self._rays = self.camera.rays(self.camera.pixel_grid()).astype(np.float32)
        rng = np.random.default_rng([line.seed, 0x6861])
        self._hall = hall.draw(
            self.camera, self._rays, rng, radius_mm=line.radius_mm, brightness=line.brightness, blur=line.blur
        )
        self._table = _CodeTable(line)
        self._noise = NoiseStock(self._rays.shape, line.seed)
        self._still: dict[float, tuple[Light, Light]] = {}
        self._patches: dict[object, glare.GlarePatch] = {}
        self._seen: dict[Sight, Seen | None] = {}
        self._codes, self._spread = np.empty_like(self._rays), np.empty_like(self._rays)

    def exposed(self, moment: Moment, frame: int) -> Picture:
        """8-bit picture before its coding, blue-green-red; the frame's number chooses the noise."""
        gain = np.float32(self.line.gain * moment.exposure)
        for plane, still in zip((self._codes, self._spread), self._still_codes(float(gain)), strict=True):
            np.copyto(plane, still)
        for place in self._touched(moment):
            self._codes[place], self._spread[place] = self._table.of(gain * self._light(moment, place))
        start = int(np.random.default_rng([self.line.seed, 0x6E73, frame]).integers(NoiseStock.EXTRA))
        np.multiply(self._spread, self._noise.cut(start), out=self._spread)
        return np.asarray(cv2.add(self._codes, self._spread, dtype=cv2.CV_8U), np.uint8)

    def jpeg(self, picture: Picture) -> bytes:
        """A picture as JPEG with halved colour resolution, as cameras send it."""
        return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, self.line.quality])[1].tobytes()

    def colour(self, sight: Sight) -> Light:
        """Linear light, blue-green-red, of an ingot of relative light 1, before the exposure.

        Its own, and 1 % of full scale that it reflects where the lamps' brightness is 1.
        """
        glowing = levels(sight.ingot.temperature_c) * sight.heating * self.line.white
        return (glowing + 0.01 * self.line.brightness).astype(np.float32)

    def seen(self, sight: Sight) -> Seen | None:
        """What the camera sees of an ingot, without blur."""
        if sight not in self._seen:
            if len(self._seen) > 4:
                self._seen.clear()
            self._seen[sight] = see(self.camera, self._rays, sight.ingot, sight.pose, MARGIN_PX)
        return self._seen[sight]

    def patch(self, moment: Moment) -> glare.GlarePatch | None:
        """The glare of a moment."""
        if moment.glare is None:
            return None
        if moment.glare not in self._patches:
            self._patches = {moment.glare: glare.draw(moment.glare, self._hall, self.line.blur.core_px)}
        return self._patches[moment.glare]

    def _still_codes(self, gain: float) -> tuple[Light, Light]:
        """Codes and their noise where nothing moves."""
        if gain not in self._still:
            if len(self._still) == GAINS_KEPT:
                self._still.pop(next(iter(self._still)))
            self._still[gain] = self._table.of(np.float32(gain) * (self._hall.light + np.float32(self.line.veil)))
        return self._still[gain]

    def _touched(self, moment: Moment) -> list[Window]:
        """Windows in which something is not as on the empty line, without overlap."""
        patch = self.patch(moment)
        windows = [] if patch is None else [(patch.rows, patch.columns)]
        windows += [self._window(sight) for sight in moment.sights if self.seen(sight) is not None]
        return _merged([place for place in windows if place[0].stop > place[0].start])

    def _window(self, sight: Sight) -> Window:
        outline = outline_px(self.camera, sight.ingot, sight.pose)
        width_px = float(np.ptp(outline[:, 0]))
        rows, columns = window(outline, max(MARGIN_PX, GLOWING / 2 * width_px), self.camera.image_size)
        return (slice(0, rows.stop), columns) if np.isfinite(sight.tongs_mm) else (rows, columns)

    def _light(self, moment: Moment, place: Window) -> Light:
        """Linear light in a window, blue-green-red, before the exposure."""
        light = self._hall.light[place].copy()
        patch = self.patch(moment)
        if patch is not None and _holds(place, (patch.rows, patch.columns)):
            light[_within(place, (patch.rows, patch.columns))] += patch.light
        for sight in moment.sights:
            self._add_glow(light, sight, place)
        for sight in moment.sights:
            self._add_ingot(light, sight, place)
            if np.isfinite(sight.tongs_mm):
                self._add_tongs(light, sight, place)
        light += np.float32(self.line.veil)
        return light

    def _add_glow(self, light: Light, sight: Sight, place: Window) -> None:
        """The line around an ingot reflects its glow, and lies in its shadow where both meet."""
        x, y = self._hall.x_mm[place][::4, ::4], self._hall.y_mm[place][::4, ::4]
        radius = sight.ingot.radius_mm
        end_x, end_y, end_z = sight.pose.end_mm
        aside = (x - end_x) / radius
        ahead = (np.maximum(y - end_y, 0) + np.maximum(end_y - sight.ingot.length_mm - y, 0)) / radius
        height = max(0.0, end_z / radius - 1)
        glow = 0.35 / (1 + aside**2 + ahead**2 + height**2) ** 1.5
        contact = np.exp(-(aside**2) - (3 * ahead) ** 2 - (2 * height) ** 2)
        size = light.shape[1], light.shape[0]
        glow, contact = (
            cv2.resize(plane.astype(np.float32), size, interpolation=cv2.INTER_LINEAR) for plane in (glow, contact)
        )
        light *= (1 - np.float32(0.7) * contact)[..., None]
        glow *= self._hall.sheen[place] * (1 - np.float32(0.8) * contact)
        light += glow[..., None] * self.colour(sight)

    def _add_ingot(self, light: Light, sight: Sight, place: Window) -> None:
        seen = self.seen(sight)
        if seen is None or not _holds(place, (seen.rows, seen.columns)):
            return
        blur, bloom = self.line.blur, np.float32(self.line.bloom)
        sharp = cv2.GaussianBlur(
            np.stack([seen.coverage, seen.light], axis=2), (0, 0), blur.core_px, borderType=cv2.BORDER_REPLICATE
        )
        rows, columns = seen.light.shape
        small = cv2.resize(seen.light, (columns // 4 + 1, rows // 4 + 1), interpolation=cv2.INTER_AREA)
        wide = cv2.resize(cv2.GaussianBlur(small, (0, 0), 2.0), (columns, rows), interpolation=cv2.INTER_LINEAR)
        part = light[_within(place, (seen.rows, seen.columns))]
        part *= 1 - sharp[..., :1]
        part += ((1 - bloom) * sharp[..., 1] + bloom * wide)[..., None] * self.colour(sight)

    def _add_tongs(self, light: Light, sight: Sight, place: Window) -> None:
        rows, columns = place
        shape = rows.stop - rows.start, columns.stop - columns.start
        covered = tongs.coverage(self.camera, sight, (columns.start, rows.start), shape)
        covered = cv2.GaussianBlur(covered, (0, 0), self.line.blur.core_px)[..., None]
        light *= 1 - covered
        light += covered * (tongs.LIGHT * np.float32(self.line.brightness) + np.float32(0.02) * self.colour(sight))


def _holds(place: Window, part: Window) -> bool:
    return all(
        outer.start <= inner.start and inner.stop <= outer.stop for outer, inner in zip(place, part, strict=True)
    )


def _within(place: Window, part: Window) -> Window:
    """A part of the picture as indices into a window that holds it."""
    rows, columns = (
        slice(inner.start - outer.start, inner.stop - outer.start) for outer, inner in zip(place, part, strict=True)
    )
    return rows, columns


def _merged(windows: list[Window]) -> list[Window]:
    """Windows that cover the same, those that overlap made one."""
    for first, a in enumerate(windows):
        for b in windows[first + 1 :]:
            if all(one.start < other.stop and other.start < one.stop for one, other in zip(a, b, strict=True)):
                rows, columns = (
                    slice(min(one.start, other.start), max(one.stop, other.stop))
                    for one, other in zip(a, b, strict=True)
                )
                return _merged([(rows, columns), *(rest for rest in windows if rest is not a and rest is not b)])
    return windows


class _CodeTable:
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
