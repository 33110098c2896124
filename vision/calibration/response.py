"""The camera's response from the board pictures that every calibration has.

Reflected about the line between a black and a white square, a board changes black for white. Whatever symmetric blur
the lens has, halo included, light at equal distances from the edge therefore adds up to black plus white:
L(d) + L(-d) = B + W. In code values it does not, and the response is the curve under which it does. A printer that
makes black squares larger by a fixed length moves the edge itself, by as many pixels as the board's scale gives; a
wrong response moves its middle and its flanks differently. So both are told apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from vision.calibration.board_edges import REACH_PX, BoardEdges
from vision.light import CURVE_PARAMETERS, ResponseCurve
from vision.sent_picture import Coding

Array = NDArray[np.float64]
Index = NDArray[np.int64]

STEP_PX = 0.25  # bins of distance
BINS = round(2 * REACH_PX / STEP_PX)
HALF = BINS // 2
FLANK_BINS = round(3.0 / STEP_PX)  # bins that are compared; further out are the plateaus
PLATEAU_PX = 3.0
LEAST_PLATEAU = 20  # pixels on either side, for a segment to count
LEAST_IN_BIN = 30  # pixels of a group, for a bin to count
LEAST_PICTURES = 8  # fewer say little of their scatter
CLIPPED_CODE = 0.97  # a white square at this code value may be overexposed
DIRECTIONS = 2  # groups of a picture: upright edges and lying ones

# What cameras have, as far as the pictures leave it open: exponents from linear to sRGB, black levels and toes of
# standards, shoulders that compress; a printer's gain in mm.
USUAL = np.array([1.9, 0.03, 0.1, 0.0])
U_USUAL = np.array([0.6, 0.04, 0.15, 0.03])
LOWEST, HIGHEST = np.array([0.5, -0.05, -0.001, -1.0]), np.array([4.0, 0.15, 2.0, 1.0])
FIRST_NOISE = 0.02  # of a bin's sum, in steps from black to white and roots of its pixels
SLOPE_STEP = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredResponse:
    """What the board pictures say of the camera's response.

    Attributes
    ----------
    curve : ResponseCurve
    gain_mm : float
        How far white squares reach over the corners' lines: negative where the printer's black runs.
    u_gain_mm : float
        Standard uncertainty.
    pictures : int
    """

    curve: ResponseCurve
    gain_mm: float
    u_gain_mm: float
    pictures: int


def measure_response(pictures: Sequence[tuple[BoardEdges, Coding]]) -> MeasuredResponse | None:
    """Response under which the flanks of all edges are symmetric.

    Least squares over exponent, offset, shoulder and printing gain; the covariance is that of the pictures'
    scatter (a sandwich with one cluster for each picture), since pixels of one picture share its levels and place.

    Parameters
    ----------
    pictures : sequence of (BoardEdges, Coding)
        Of all board pictures of cameras of one kind.

    Returns
    -------
    MeasuredResponse or None
        None with fewer than `LEAST_PICTURES` pictures whose squares are large enough and not overexposed.
    """
    flanks = _Flanks.of_pictures(pictures)
    if flanks.pictures < LEAST_PICTURES:
        return None
    noise, values = FIRST_NOISE, np.clip(USUAL, LOWEST + SLOPE_STEP, HIGHEST - SLOPE_STEP)
    for _ in range(2):
        values = _fitted(flanks, values, noise)
        noise = max(1e-3, float(np.sqrt(np.mean(flanks.asymmetry(values) ** 2))))
    covariance = _covariance(flanks, values, noise)
    exponent, offset, shoulder, gain_mm = values.tolist()
    size = len(CURVE_PARAMETERS)
    curve = ResponseCurve(exponent, offset, shoulder, covariance[:size, :size])
    return MeasuredResponse(curve, gain_mm, float(np.sqrt(covariance[size, size])), flanks.pictures)


def _fitted(flanks: "_Flanks", start: Array, noise: float) -> Array:
    def residuals(values: Array) -> Array:
        return np.concatenate([flanks.asymmetry(values).ravel() / noise, (values - USUAL) / U_USUAL])

    found = least_squares(
        residuals, start, bounds=(LOWEST, HIGHEST), x_scale=0.3 * U_USUAL, diff_step=SLOPE_STEP, max_nfev=12
    )
    return np.asarray(found.x, dtype=np.float64)


def _covariance(flanks: "_Flanks", values: Array, noise: float) -> Array:
    """Sandwich: what is known of the parameters beforehand, and the scatter of the pictures' own wishes."""
    steps = SLOPE_STEP * np.eye(len(values))
    slopes = np.stack(
        [(flanks.asymmetry(values + step) - flanks.asymmetry(values - step)) / (2 * SLOPE_STEP) for step in steps], -1
    )
    wishes = np.einsum("gbp,gb->gp", slopes, flanks.asymmetry(values)).reshape(-1, DIRECTIONS, len(values)).sum(axis=1)
    known = np.einsum("gbp,gbq->pq", slopes, slopes) / noise**2 + np.diag(U_USUAL**-2.0)
    count = flanks.pictures
    scatter = wishes.T @ wishes / noise**4 * count / (count - len(values)) + np.diag(U_USUAL**-2.0)
    inverse = np.linalg.inv(known)
    return inverse @ scatter @ inverse


@dataclass(frozen=True, slots=True, eq=False)
class _Flanks:
    """Pixels of all pictures; a group is a picture's edges of one direction.

    Attributes
    ----------
    code : ndarray of int64, shape (n,)
        Place in the tables of all codings, one after the other.
    unit : ndarray of float64
        Code value, 0 to 1, of each place.
    segment : ndarray of int64, shape (n,)
    bin : ndarray of int64, shape (n,)
        Number of group and bin together.
    white, black : ndarray of bool, shape (n,)
        Pixels of the plateaus.
    count : ndarray of int64, shape (groups, BINS)
        Pixels of each bin.
    px_per_mm : ndarray of float64, shape (groups,)
    """

    code: Index
    unit: Array
    segment: Index
    bin: Index
    white: NDArray[np.bool_]
    black: NDArray[np.bool_]
    count: Index
    px_per_mm: Array

    @property
    def pictures(self) -> int:
        """Pictures with any edge that counts."""
        return int(np.count_nonzero(self.count.reshape(-1, DIRECTIONS * BINS).any(axis=1)))

    @classmethod
    def of_pictures(cls, pictures: Sequence[tuple[BoardEdges, Coding]]) -> "_Flanks":
        codings = list(dict.fromkeys(coding for _, coding in pictures))
        units = [(np.arange(1 << c.bits) - c.black) / (c.white - c.black) for c in codings]
        start = dict(zip(codings, np.cumsum([0, *map(len, units)])[:-1].tolist(), strict=True))
        unit = np.maximum(np.concatenate([*units, np.zeros(1)]), 0.0)
        edges = [one for one, _ in pictures]
        code = _joined([one.code + start[coding] for one, coding in pictures])
        distance = _joined([one.distance_px for one in edges]).astype(np.float64)
        number = np.repeat(np.arange(len(edges)), [len(one.code) for one in edges])
        named = number * 100_000 + _joined([one.segment for one in edges])
        segment = np.unique(named, return_inverse=True)[1]
        group = DIRECTIONS * number + _joined([one.upright for one in edges]).astype(np.int64)
        used = _usable(unit[code], distance, segment)[segment]
        groups = DIRECTIONS * len(edges)
        place = np.clip(np.floor((distance + REACH_PX) / STEP_PX).astype(np.int64), 0, BINS - 1)
        bins = (group * BINS + place)[used]
        scale = np.bincount(group[used], _joined([one.px_per_mm for one in edges])[used], groups)
        return cls(
            code=code[used],
            unit=unit,
            segment=segment[used],
            bin=bins,
            white=(distance > PLATEAU_PX)[used],
            black=(distance < -PLATEAU_PX)[used],
            count=np.bincount(bins, minlength=groups * BINS).reshape(groups, BINS).astype(np.int64),
            px_per_mm=scale / np.maximum(np.bincount(group[used], minlength=groups), 1),
        )

    def asymmetry(self, values: Array) -> Array:
        """y(d) + y(-d) - 1 after the printing gain, over its noise, shape (groups, FLANK_BINS); 0 in empty bins.

        y is the light of a bin between the plateaus of its edges, 0 on black and 1 on white.
        """
        y = self._profiles(ResponseCurve(*values[: len(CURVE_PARAMETERS)].tolist()))
        slope = np.gradient(y, STEP_PX, axis=1)
        steep = slope[:, HALF:] + slope[:, :HALF][:, ::-1]
        off = y[:, HALF:] + y[:, :HALF][:, ::-1] - 1 + steep * (values[-1] * self.px_per_mm)[:, None]
        pixels = np.minimum(self.count[:, HALF:], self.count[:, :HALF][:, ::-1])
        return np.where(pixels > LEAST_IN_BIN, off * np.sqrt(pixels), 0.0)[:, :FLANK_BINS]

    def _profiles(self, curve: ResponseCurve) -> Array:
        light = curve.light(self.unit)[self.code]
        white, black = (_means(light[side], self.segment[side], self.segment) for side in (self.white, self.black))
        share = (light - black[self.segment]) / (white - black)[self.segment]
        return np.bincount(self.bin, share, self.count.size).reshape(self.count.shape) / np.maximum(self.count, 1)


def _joined(parts: list[Array] | list[Index] | list[NDArray[np.bool_]]) -> NDArray[np.generic]:
    return np.concatenate(parts) if parts else np.empty(0, np.int64)


def _means(values: Array, segment: Index, of: Index) -> Array:
    size = int(of.max()) + 1
    return np.bincount(segment, values, size) / np.maximum(np.bincount(segment, minlength=size), 1)


def _usable(code: Array, distance: Array, segment: Index) -> NDArray[np.bool_]:
    """Segments with enough of both plateaus, white above black and not overexposed."""
    size = int(segment.max()) + 1 if segment.size else 0
    sides = [distance > PLATEAU_PX, distance < -PLATEAU_PX]
    count = [np.bincount(segment[side], minlength=size) for side in sides]
    white, black = (
        np.bincount(segment[side], code[side], size) / np.maximum(n, 1) for side, n in zip(sides, count, strict=True)
    )
    return (np.minimum(*count) > LEAST_PLATEAU) & (white < CLIPPED_CODE) & (white > black)
