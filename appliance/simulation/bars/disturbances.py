"""What comes between the bar and a picture: a post, haze, glare, hot air, a cap on the lens.

Each belongs to one camera, changes its linear light before the noise, and gives the light back.
"""

from dataclasses import dataclass
from typing import Literal, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars.bars import REFERENCE_C, Bar, levels
from appliance.simulation.bars.line_scene import View
from appliance.simulation.bars.silhouette import axis_distance, rounded
from appliance.simulation.sensor import Light, blurred_step

Side = Literal["left", "right"]
Field = NDArray[np.float64]

GLOW = levels(REFERENCE_C).astype(np.float32)[:, None, None]  # light that a hot bar lends to what is around it
HAZE_CELL_PX = 150
MOST_DRIFT_PX = 800
SHIMMER_CELL_PX = 20
CUBIC_SPREAD = 0.859  # standard deviation of unit noise after cubic interpolation, over all places


class Disturbance(Protocol):
    """One thing that spoils one camera's pictures."""

    @property
    def side(self) -> Side:
        """The camera."""
        ...

    def changed(self, light: Light, view: View, frame: int) -> Light:
        """Linear light, shape (3, rows, columns), with the disturbance; may overwrite `light`."""
        ...


@dataclass(frozen=True, slots=True)
class Post:
    """A round upright post before a camera, out of focus.

    Attributes
    ----------
    side : str
    foot_mm : tuple of float
        x and y of its axis.
    radius_mm : float
    light : float
        Grey level in linear light; above some tenths the post is lit.
    soft_px : float
        Standard deviation of its blurred edges.
    """

    side: Side
    foot_mm: tuple[float, float]
    radius_mm: float
    light: float
    soft_px: float

    def changed(self, light: Light, view: View, frame: int) -> Light:  # noqa: ARG002  a post stands still
        """Light with the post before everything."""
        coverage = self.coverage(view)
        light += coverage * (np.float32(self.light) - light)
        return light

    def coverage(self, view: View) -> Light:
        """Part of each pixel that the post hides, shape (rows, columns)."""
        from_axis = np.append(view.camera.centre_mm[:2] - self.foot_mm, 0.0)
        normal = np.cross([0.0, 0.0, 1.0], from_axis)
        q = view.rays @ normal / np.hypot(view.rays[..., 0], view.rays[..., 1])
        ahead = view.rays @ from_axis < 0
        down, right = np.gradient(q)
        scale = self.soft_px * np.hypot(down, right)
        hidden = blurred_step((self.radius_mm - q) / scale) - blurred_step((-self.radius_mm - q) / scale)
        return (ahead * hidden).astype(np.float32)


@dataclass(frozen=True, slots=True)
class Haze:
    """Steam or smoke, lit by the bar: takes light away and puts a veil in its place, smooth over the picture.

    Attributes
    ----------
    side : str
    seed : int
    density : float
        Mean part of the light that is lost.
    veil : float
        Light of a dense veil over that of the bar.
    """

    side: Side
    seed: int
    density: float
    veil: float = 0.25

    def changed(self, light: Light, view: View, frame: int) -> Light:  # noqa: ARG002  drifts slowly
        """Light behind the haze."""
        noise = smooth_field(np.random.default_rng([self.seed, 0x6861]), view.rays.shape[:2], HAZE_CELL_PX)
        density = np.clip(self.density * (1 + 0.3 * noise), 0, 0.95).astype(np.float32)
        light += density * (np.float32(self.veil) * GLOW - light)
        return light


@dataclass(frozen=True, slots=True)
class DriftingHaze:
    """Steam that thickens and drifts from frame to frame, with more structure than `Haze`.

    Attributes
    ----------
    side : str
    seed : int
    density : float
        Mean part of the light that is lost in frame 0.
    growth : float
        Added to it in each frame.
    drift_px : float
        How far the steam moves across the picture in each frame.
    cell_px : int
        Size of its structure.
    veil : float
        Light of a dense veil over that of the bar.
    """

    side: Side
    seed: int
    density: float
    growth: float
    drift_px: float
    cell_px: int
    veil: float = 0.25

    def changed(self, light: Light, view: View, frame: int) -> Light:
        """Light behind the haze."""
        rows, columns = view.rays.shape[:2]
        moved = round(abs(self.drift_px) * frame)
        noise = smooth_field(np.random.default_rng([self.seed, 0x6468]), (rows, columns + MOST_DRIFT_PX), self.cell_px)
        noise = np.roll(noise, moved if self.drift_px > 0 else -moved, axis=1)[:, MOST_DRIFT_PX // 2 :][:, :columns]
        density = np.clip((self.density + self.growth * frame) * (1 + 0.3 * noise), 0, 0.9).astype(np.float32)
        light += density * (np.float32(self.veil) * GLOW - light)
        return light


@dataclass(frozen=True, slots=True)
class Glare:
    """A bright blob with a soft edge, added to the picture, as of a lamp's or a flame's reflection.

    Attributes
    ----------
    side : str
    centre_px : tuple of float
        x, y.
    radius_px : float
        Where its light has fallen to half.
    soft_px : float
        Standard deviation of its edge.
    light : float
        Grey level that it adds.
    """

    side: Side
    centre_px: tuple[float, float]
    radius_px: float
    soft_px: float
    light: float

    def changed(self, light: Light, view: View, frame: int) -> Light:  # noqa: ARG002  stands still
        """Light with the blob added."""
        rows, columns = np.ogrid[: view.rays.shape[0], : view.rays.shape[1]]
        distance = np.hypot(columns - self.centre_px[0], rows - self.centre_px[1])
        light += np.float32(self.light) * blurred_step((self.radius_px - distance) / self.soft_px)
        return light


@dataclass(frozen=True, slots=True)
class Shimmer:
    """Hot air on and beside a bar that bends the light, anew in each frame.

    Attributes
    ----------
    side : str
    seed : int
    bar : Bar
    shift_px : float
        Standard deviation of the displacement in x and in y over the bar; it fades within a radius beside it.
    """

    side: Side
    seed: int
    bar: Bar
    shift_px: float

    def changed(self, light: Light, view: View, frame: int) -> Light:
        """Light displaced by a smooth random field."""
        dx, dy = self.displacement_px(view, frame)
        rows, columns = (grid.astype(np.float32) for grid in np.mgrid[: dx.shape[0], : dx.shape[1]])
        moved = cv2.remap(
            np.moveaxis(light, 0, -1), columns + dx, rows + dy, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
        )
        return np.ascontiguousarray(np.moveaxis(np.maximum(moved, 0), -1, 0), np.float32)

    def displacement_px(self, view: View, frame: int) -> Light:
        """From where each pixel's light comes, in x and in y, shape (2, rows, columns)."""
        rng = np.random.default_rng([self.seed, self.side == "right", frame])
        radius_mm = self.bar.diameter_mm / 2
        distance_mm = np.abs(axis_distance(*rounded(view.camera.centre_mm, view.rays, self.bar), self.bar))
        hot = np.exp(-((np.maximum(distance_mm - radius_mm, 0) / radius_mm) ** 2))
        fields = [smooth_field(rng, distance_mm.shape, SHIMMER_CELL_PX) for _ in range(2)]
        return (self.shift_px * hot * np.stack(fields)).astype(np.float32)


@dataclass(frozen=True, slots=True)
class Blind:
    """A camera that sees an even grey instead of the line: 0 when it is dark, more when its window is covered."""

    side: Side
    light: float

    def changed(self, light: Light, view: View, frame: int) -> Light:  # noqa: ARG002
        """The even grey."""
        return np.full_like(light, self.light)


def smooth_field(rng: np.random.Generator, shape: tuple[int, ...], cell_px: int) -> Field:
    """Random field of mean 0 and standard deviation 1 over many draws, smooth within `cell_px`."""
    rows, columns = (size // cell_px + 4 for size in shape)
    coarse = rng.standard_normal((rows, columns))
    smooth = cv2.resize(coarse, None, fx=cell_px, fy=cell_px, interpolation=cv2.INTER_CUBIC)
    start = rng.integers(cell_px, 2 * cell_px, 2)
    field = smooth[start[0] : start[0] + shape[0], start[1] : start[1] + shape[1]]
    return (field / CUBIC_SPREAD).astype(np.float64)
