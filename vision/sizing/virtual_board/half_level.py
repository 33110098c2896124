"""One edge of the bar in a turned region: rows that have an edge, moved to half level in linear light."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.compression import compression_shift_px
from vision.edges.subpixel import Crossings, edge_blur_px, edge_shading, half_level_crossing
from vision.edges.symmetric_plane import settled
from vision.geometry.robust_constants import SIGMA_PER_MAD
from vision.geometry.robust_line import robust_line
from vision.geometry.turned_region import Region
from vision.light import half_level_doubts_px
from vision.light_planes import Decoder, LightPlane
from vision.order_statistics import median, median_without_nan, quantiles
from vision.sizing.limits import CLIPPED_FEW_SHARE, FIRST_BLUR_PX

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LINE_DISTANCE_PX = 2.5  # chosen: boundary points further from the frame's line are not on the bar's edge
PROFILE_HALF_LENGTH_PX, PROFILE_STEP_PX = 9, 0.5  # chosen: half length of a row's profile across an edge, and its step
OFFSETS_PX = np.arange(-PROFILE_HALF_LENGTH_PX, PROFILE_HALF_LENGTH_PX + PROFILE_STEP_PX, PROFILE_STEP_PX)
SPARSE_ROW_STEP, BLUR_ROW_STEP = 4, 4  # chosen: the first line, and the blur along it, are found on every fourth row
# A row has an edge if its step of light is at least 10 % of the frame's 90th percentile; oxide leaves about 20 %, an
# empty line less than 10 %.
LEAST_STEP_SHARE = 0.1
LEAST_GATE_PX = 0.3  # chosen: points within 0.3 px of the line are kept, however little the others scatter
GATE_SIGMAS = 3  # chosen: points further from the line than 3 robust standard deviations are left out
LEAST_ROWS = 20  # chosen: with an edge in fewer rows there is no limb
BRIGHTEST_SHARE = 0.9  # chosen: a channel clips if a tenth of the bar's rows do


@dataclass(frozen=True, slots=True, eq=False)
class LimbRows:
    """One edge of the bar, row by row.

    Attributes
    ----------
    column : ndarray of float64, shape (rows,)
        NaN where the row has no edge.
    area : ndarray of float64, shape (rows,)
        Of the boundaries of interest, pixels.
    line : ndarray of float64, shape (2,), or None
        Slope and start of column(row); None when the edge was not found.
    clipped_share : float
        Share of overexposed rows, which were left out.
    contrast : float
        Light of the bar over that of its background; infinite without half level.
    u_light_px : float
        Standard uncertainty of the edge's place from the response and from compression.
    """

    column: Array
    area: Array
    line: Array | None
    clipped_share: float = 0.0
    contrast: float = np.inf
    u_light_px: float = 0.0

    @classmethod
    def nothing(cls, area: Array, clipped_share: float = 0.0) -> "LimbRows":
        """Return an edge that was not found.

        Parameters
        ----------
        area : ndarray of float64, shape (rows,)
        clipped_share : float
            See `LimbRows`.
        """
        return cls(np.full(len(area), np.nan), area, None, clipped_share)


@dataclass(frozen=True, slots=True, eq=False)
class ThinEdges:
    """Pixels of thin edges in the strip along one edge of the bar, n of them.

    Attributes
    ----------
    row : ndarray of int64, shape (n,)
    column : ndarray of float64, shape (n,)
    area : ndarray of float64, shape (rows,)
        See `LimbRows`.
    """

    row: Index
    column: Array
    area: Array

    @property
    def rows(self) -> Index:
        """Rows with any edge."""
        return np.flatnonzero(np.bincount(self.row))

    def near(self, line: Array) -> Array:
        """Mean column of the pixels near a line in each row of the region, NaN without any."""
        near = np.abs(self.column - (line[0] * self.row + line[1])) <= LINE_DISTANCE_PX
        count = np.bincount(self.row[near], minlength=len(self.area))
        total = np.bincount(self.row[near], self.column[near], minlength=len(self.area))
        return total / np.where(count > 0, count, np.nan)


def line_of(row: Array | Index, column: Array) -> Array | None:
    """Robust line through the finite points.

    Parameters
    ----------
    row, column : ndarray of float64, shape (n,)
        `row` increasing; `column` NaN where the row has no point.

    Returns
    -------
    ndarray of float64, shape (2,), or None
        Slope and start of column(row); None with fewer than `LEAST_ROWS` points.
    """
    there = np.isfinite(column)
    return robust_line(row[there].astype(np.float64), column[there]) if there.sum() >= LEAST_ROWS else None


@dataclass(frozen=True, slots=True, eq=False)
class HalfLevel:
    """Finds half level along one edge.

    Attributes
    ----------
    region : Region
    side : int
        -1 for the edge at smaller columns, +1 for the other.
    decoder : Decoder
        Of the camera's code values.
    """

    region: Region
    side: int
    decoder: Decoder

    def locate(self, line: Array, edges: ThinEdges) -> LimbRows:
        """Edge of each row, from the brightest channel that is not overexposed along the edge.

        Parameters
        ----------
        line : ndarray of float64, shape (2,)
            Slope and start of the edge, to within a few pixels.
        edges : ThinEdges

        Returns
        -------
        LimbRows
        """
        tried: list[LimbRows] = []
        levels = *self._levels(line, -1, (0.5,)), *self._levels(line, 1, (0.5, BRIGHTEST_SHARE))
        few = edges.rows[:: SPARSE_ROW_STEP**2]
        planes = self.decoder.planes(self.region.raw.coding, *levels)
        for plane in settled(planes, lambda plane: self._profiles(plane, line, few)[0], OFFSETS_PX):
            tried.append(self._in_plane(plane, line, edges))
            if tried[-1].clipped_share <= CLIPPED_FEW_SHARE:
                break
        return min(tried, key=lambda limb: limb.clipped_share)

    def _in_plane(self, plane: LightPlane, line: Array, edges: ThinEdges) -> LimbRows:
        """Two passes: the outermost rise of light finds the line; half level is taken around it."""
        sparse = edges.rows
        sparse = sparse[sparse % SPARSE_ROW_STEP == 0] if len(sparse) > 3 * SPARSE_ROW_STEP * LEAST_ROWS else sparse
        profile, middle = self._profiles(plane, line, sparse)
        place = half_level_crossing(profile, OFFSETS_PX, FIRST_BLUR_PX).place_px
        better, blur_px = line_of(sparse, middle - self.side * place), _blur_px(profile, place)
        if better is None or blur_px is None:
            return LimbRows.nothing(edges.area)
        at = np.flatnonzero(np.isfinite(edges.near(better)))
        profile, middle = self._profiles(plane, better, at)
        crossings = _shaded_crossings(profile, at, blur_px)
        levels = crossings.dark, crossings.bright
        inwards_px, u_inwards_px = compression_shift_px(self.region.raw.coding, plane, levels, blur_px)
        middle += self.side * inwards_px
        limb = self._limb(crossings, at, middle, edges, plane.clipped_light)
        if limb.line is None:
            return limb
        found = np.isfinite(crossings.place_px)
        doubts_px = half_level_doubts_px(
            self.decoder.response, (crossings.dark[found], crossings.bright[found]), blur_px
        )
        return replace(limb, u_light_px=float(np.linalg.norm([*doubts_px, u_inwards_px])))

    def _limb(self, crossings: Crossings, at: Index, middle: Array, edges: ThinEdges, clipped_light: float) -> LimbRows:
        there = _steps(crossings)
        clipped = there & (crossings.bright >= clipped_light)
        share = float(np.count_nonzero(clipped) / max(1, np.count_nonzero(there)))
        column = np.full(len(edges.area), np.nan)
        column[at] = np.where(there & ~clipped, middle - self.side * crossings.place_px, np.nan)
        line = line_of(np.arange(len(column)), column)
        if line is None:
            return LimbRows.nothing(edges.area, share)
        with np.errstate(divide="ignore", invalid="ignore"):
            contrast = median(crossings.bright[there]) / median(crossings.dark[there])
        return LimbRows(_on_line(column, line), edges.area, line, share, contrast)

    def _profiles(self, plane: LightPlane, line: Array, rows: Index) -> tuple[Array, Array]:
        """Light along rows from the background to the bar, and the columns of the profiles' middles."""
        middle = line[0] * rows + line[1]
        return self.region.light(rows, middle[:, None] - self.side * OFFSETS_PX, plane), middle

    def _levels(self, line: Array, way: int, shares: tuple[float, ...]) -> list[Array]:
        """Quantiles of each channel's code values as shown just inside the edge (1) or outside."""
        rows, columns = self.region.shape
        inside = np.rint(line[0] * np.arange(rows) + line[1]).astype(np.int64) - way * self.side * (
            PROFILE_HALF_LENGTH_PX - 1
        )
        return quantiles(self.region.at(np.clip(inside, 0, columns - 1)[:, None]).reshape(rows, -1), shares)


def _shaded_crossings(profile: Array, at: Index, blur_px: float) -> Crossings:
    """Half level around the middles of profiles, corrected for the bar's shading towards its edge."""
    few = at % SPARSE_ROW_STEP == 0
    even = half_level_crossing(profile[few], OFFSETS_PX, blur_px, expected_px=0.0)
    shading = edge_shading(profile[few], OFFSETS_PX, even, blur_px)
    return half_level_crossing(profile, OFFSETS_PX, blur_px, expected_px=0.0, shading=shading)


def _steps(crossings: Crossings) -> NDArray[np.bool_]:
    """Rows whose edge is a step of the bar's light."""
    step = np.where(np.isfinite(crossings.place_px), crossings.bright - crossings.dark, np.nan)
    known = step[np.isfinite(step)]
    with np.errstate(invalid="ignore"):
        return step >= LEAST_STEP_SHARE * quantiles(known, (0.9,))[0] if known.size else np.zeros(len(step), dtype=bool)


def _blur_px(profile: Array, place: Array) -> float | None:
    found = np.flatnonzero(np.isfinite(place))
    if found.size < LEAST_ROWS:
        return None
    sample = found[:: max(1, min(BLUR_ROW_STEP, found.size // LEAST_ROWS))]
    return edge_blur_px(profile[sample], OFFSETS_PX, place[sample])


def _on_line(column: Array, line: Array) -> Array:
    """Columns without those off the line by more than their scatter explains."""
    away = np.abs(column - (line[0] * np.arange(len(column)) + line[1]))
    limit = max(LEAST_GATE_PX, GATE_SIGMAS * SIGMA_PER_MAD * median_without_nan(away))
    return np.where(away <= limit, column, np.nan)
