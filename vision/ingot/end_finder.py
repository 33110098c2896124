"""Finds the round end of the ingot that lies on the line, in one picture: algorithms 15 and 16.

Hot steel is bright in red and weak in blue, lamps and their glare are white: red finds regions (algorithm 15), red
minus blue says which of their pixels are hot. The circle is then drawn to the edge between hot and not hot.
"""

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.ingot.end_circle import Circle, fit_lower_arc, vote_for_circle
from vision.pictures import check_picture
from vision.reasons import IngotReason

Picture = NDArray[np.uint8]
Mask = NDArray[np.uint8]

WIDE_RADIUS_SHARES = (0.02, 0.11)  # chosen: radii of ends of any size, over the picture's width
AREA_FACTORS = (3.2, 7.5)  # chosen: area of an ingot's region over the square of its end's radius
BODY_HALF_WIDTH = 1.15  # chosen: half width of an ingot's body, in radii of its end


class Box(NamedTuple):
    """Upright rectangle in full-image pixels; holds columns x to x + width - 1."""

    x: int
    y: int
    width: int
    height: int

    def holds(self, x: float, y: float) -> bool:
        """Whether a point lies inside.

        Parameters
        ----------
        x, y : float
            Full-image pixels.
        """
        return self.x <= x < self.x + self.width and self.y <= y < self.y + self.height


@dataclass(frozen=True, slots=True, kw_only=True)
class EndLimits:
    """Limits of an end on the line; the first three are those of algorithm 15.

    Attributes
    ----------
    area_px : tuple of float
        Smallest and largest area of the ingot's region.
    tilt_deg : float
        Largest angle of the region's long axis from the vertical, either way.
    radius_px : tuple of float
        Smallest and largest radius of the end.
    red_floor : int
        Lowest threshold of the red channel, 0 to 255: Otsu's may not fall below it where nothing is hot.
    warmth : int
        Least difference of red and blue of a hot pixel, 0 to 255; not used on grey pictures.
    length : float
        Longest region, as a multiple of its end's diameter; a longer one is being lowered on end.
    arc : float
        Least share of the end's lower half circle that must be seen as an edge.
    """

    area_px: tuple[float, float] = (5000.0, 14000.0)
    tilt_deg: float = 15.0
    radius_px: tuple[float, float] = (30.0, 60.0)
    red_floor: int = 100
    warmth: int = 30
    length: float = 2.0
    arc: float = 0.6

    @classmethod
    def wide(cls, columns: int) -> "EndLimits":
        """Limits for ends of any plausible size, in pictures of so many columns."""
        radius_px = WIDE_RADIUS_SHARES[0] * columns, WIDE_RADIUS_SHARES[1] * columns
        return cls(area_px=cls.area_of(radius_px), radius_px=radius_px)

    @staticmethod
    def area_of(radius_px: tuple[float, float]) -> tuple[float, float]:
        """Areas of ingots that lie on the line, from the radii of their ends."""
        return AREA_FACTORS[0] * radius_px[0] ** 2, AREA_FACTORS[1] * radius_px[1] ** 2

    def __post_init__(self) -> None:
        for name, (least, most) in (("area_px", self.area_px), ("radius_px", self.radius_px)):
            if not 0 < least < most:
                raise ValueError(f"{name} must be two growing numbers above 0, got {(least, most)}")


@dataclass(frozen=True, slots=True)
class End:
    """The end of an ingot in one picture, in full-image pixels.

    Attributes
    ----------
    center_x, center_y, radius : float
    method : {"region", "circle"}
        "region" by algorithm 15, "circle" by algorithm 16.
    """

    center_x: float
    center_y: float
    radius: float
    method: Literal["region", "circle"]


@dataclass(frozen=True, slots=True)
class _Region:
    """A connected region of the crop, in its pixels: box, area, centroid, angle of the long axis from the vertical."""

    box: Box
    area_px: float
    centroid: tuple[float, float]
    tilt_deg: float

    @property
    def circle(self) -> Circle:
        """Circle in the bottom square."""
        radius = self.box.width / 2
        return Circle(self.box.x + radius - 0.5, self.box.y + self.box.height - radius - 0.5, radius)


class EndFinder:
    """Finds ends in pictures of one camera.

    Parameters
    ----------
    crop : Box
        Part of the picture that is searched.
    centroid : Box
        Where the centroid of an ingot on the line may be.
    limits : EndLimits

    Raises
    ------
    ValueError
        A box is empty or begins outside the picture.
    """

    def __init__(self, crop: Box, centroid: Box, limits: EndLimits | None = None) -> None:
        for name, box in (("crop", crop), ("centroid", centroid)):
            if min(box.x, box.y) < 0 or min(box.width, box.height) < 1:
                raise ValueError(f"{name} must be a box inside the picture, got {tuple(box)}")
        self._crop = crop
        self._centroid = centroid
        self._limits = limits or EndLimits()

    def find(self, picture: Picture) -> tuple[End | None, IngotReason]:
        """Find the end of the ingot on the line.

        Parameters
        ----------
        picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
            Grey, or blue-green-red.

        Returns
        -------
        End or None
            None when there is none, or none on the line.
        IngotReason
            Without an end, why: `NOTHING_HOT` (no hot region), `HANGING` (cut by the crop's upper side, or longer than
            an ingot that lies), `OUTSIDE` (centroid elsewhere, or cut by another side), `TOO_SMALL`, `TOO_LARGE`,
            `TILTED`, `NO_CIRCLE` (its lower edge is no arc). With one: `GLARE_JOINED` (algorithm 16 was needed) and
            `SEVERAL_ENDS` (the largest is taken), or none.

        Raises
        ------
        ValueError
            `picture` is not of uint8, has another shape, or does not hold the crop.
        """
        red, warmth = self._channels(picture)
        level, _ = cv2.threshold(red, 0, 255, cv2.THRESH_OTSU)
        bright = _mask(red > max(level, self._limits.red_floor))
        hot = bright if warmth is red else bright & _mask(warmth >= self._limits.warmth)
        found = [self._by_region(region, warmth) for region in self._regions(bright, hot)]
        ends = [end for end, _ in found if end is not None]
        if ends:
            return ends[0], IngotReason.SEVERAL_ENDS if len(ends) > 1 else IngotReason.NONE
        if not found:
            return None, IngotReason.NOTHING_HOT
        return self._by_circle(hot, warmth, found[0][1])

    def _channels(self, picture: Picture) -> tuple[Picture, Picture]:
        """Red and warmth of the crop; a grey picture is its own red and its own warmth."""
        check_picture("picture", picture)
        crop = self._crop
        rows, columns = picture.shape[:2]
        if crop.x + crop.width > columns or crop.y + crop.height > rows:
            raise ValueError(f"picture of {columns} x {rows} does not hold the crop {tuple(crop)}")
        part = picture[crop.y : crop.y + crop.height, crop.x : crop.x + crop.width]
        if part.ndim == 2:
            grey = np.ascontiguousarray(part)
            return grey, grey
        red = cv2.extractChannel(part, 2)
        return np.asarray(red, np.uint8), np.asarray(cv2.subtract(red, cv2.extractChannel(part, 0)), np.uint8)

    def _regions(self, bright: Mask, hot: Mask) -> list[_Region]:
        """Bright regions that are hot and large enough to hold an end, largest first."""
        least_px = self._limits.radius_px[0] ** 2  # a third of the disc
        return _connected(bright, hot, least_px)

    def _by_region(self, region: _Region, warmth: Picture) -> tuple[End | None, IngotReason]:
        """Algorithm 15 for one region; without an end, why."""
        least, most = self._limits.area_px
        if region.area_px < least:
            return None, IngotReason.TOO_SMALL
        if region.area_px > most:
            return None, IngotReason.TOO_LARGE
        return self._checked(region, region.circle, warmth, "region")

    def _by_circle(self, hot: Mask, warmth: Picture, why: IngotReason) -> tuple[End | None, IngotReason]:
        """Algorithm 16, for a region that glare has joined or an end that does not fit into its bottom square."""
        circle = vote_for_circle(warmth, hot, self._limits.radius_px)
        if circle is None:
            return None, why
        around = _region_at(_beside(hot, circle), circle)
        if around is None:
            return None, why
        end, reason = self._checked(around, circle, warmth, "circle")
        if end is None:
            return None, reason if reason is not IngotReason.NO_CIRCLE else why
        return end, IngotReason.GLARE_JOINED

    def _checked(
        self, region: _Region, circle: Circle, warmth: Picture, method: Literal["region", "circle"]
    ) -> tuple[End | None, IngotReason]:
        limits, crop = self._limits, self._crop
        if region.box.y == 0:
            return None, IngotReason.HANGING
        if self._is_cut(region.box):
            return None, IngotReason.OUTSIDE
        fitted = fit_lower_arc(warmth, circle, limits.arc)
        if fitted is None:
            return None, IngotReason.NO_CIRCLE
        x, y, radius = fitted
        reason = self._misplaced(region, fitted)
        if reason is not IngotReason.NONE:
            return None, reason
        if not limits.radius_px[0] <= radius <= limits.radius_px[1]:
            return None, IngotReason.TOO_SMALL if radius < limits.radius_px[0] else IngotReason.TOO_LARGE
        return End(float(x + crop.x), float(y + crop.y), float(radius), method), IngotReason.NONE

    def _misplaced(self, region: _Region, circle: Circle) -> IngotReason:
        limits = self._limits
        length_px = circle.y + circle.radius - region.box.y
        if length_px > limits.length * 2 * circle.radius:
            return IngotReason.HANGING
        if abs(region.tilt_deg) > limits.tilt_deg:
            return IngotReason.TILTED
        x, y = region.centroid
        return IngotReason.NONE if self._centroid.holds(x + self._crop.x, y + self._crop.y) else IngotReason.OUTSIDE

    def _is_cut(self, box: Box) -> bool:
        """Whether a box of the crop touches the crop's left, right or lower side."""
        crop = self._crop
        return box.x == 0 or box.x + box.width == crop.width or box.y + box.height == crop.height


def _mask(true: NDArray[np.bool_]) -> Mask:
    return true.view(np.uint8)


def _connected(mask: Mask, hot: Mask, least_px: float) -> list[_Region]:
    """8-connected regions with at least so many hot pixels, largest first."""
    count, labels = cv2.connectedComponents(mask, connectivity=8)  # statistics of all would take seven times as long
    hot_px = np.bincount(labels[hot > 0], minlength=count)
    regions = [_described(labels, label) for label in range(1, count) if hot_px[label] >= least_px]
    return sorted(regions, key=lambda region: -region.area_px)


def _described(labels: NDArray[Any], label: int) -> _Region:
    box = Box(*cv2.boundingRect(_mask(labels == label)))
    inside = labels[box.y : box.y + box.height, box.x : box.x + box.width] == label
    moments = cv2.moments(_mask(inside), binaryImage=True)
    area_px = moments["m00"]
    centroid = (moments["m10"] + box.x * area_px) / area_px, (moments["m01"] + box.y * area_px) / area_px
    axis_deg = 0.5 * np.degrees(np.arctan2(2 * moments["mu11"], moments["mu20"] - moments["mu02"]))
    tilt_deg = (axis_deg + 180) % 180 - 90  # from the vertical
    return _Region(box, area_px, centroid, float(tilt_deg))


def _beside(hot: Mask, circle: Circle) -> Mask:
    """Hot pixels above and around an end, without glare that lies beside or below."""
    left, right = (max(0, round(circle.x + side * BODY_HALF_WIDTH * circle.radius)) for side in (-1, 1))
    below = max(0, round(circle.y + BODY_HALF_WIDTH * circle.radius))
    part = np.zeros_like(hot)
    part[:below, left:right] = hot[:below, left:right]
    return part


def _region_at(hot: Mask, circle: Circle) -> _Region | None:
    """The hot region that covers most of a circle's inside."""
    count, labels = cv2.connectedComponents(hot, connectivity=8)
    disc = np.zeros_like(hot)
    cv2.circle(disc, (round(circle.x), round(circle.y)), max(1, round(0.8 * circle.radius)), 1, -1)
    inside = np.bincount(labels[disc > 0], minlength=count)
    inside[0] = 0
    label = int(np.argmax(inside))
    if inside[label] < 0.5 * np.count_nonzero(disc):
        return None
    return _described(labels, label)
