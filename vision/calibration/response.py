"""The camera's response from the board pictures that every calibration has.

Reflected about the line between a black and a white square, a board changes black for white. Whatever symmetric blur
the lens has, halo included, light at equal distances from the edge therefore adds up to black plus white:
L(d) + L(-d) = B + W. In code values it does not, and the response is the curve under which it does. A printer that
makes black squares larger by a fixed length moves the edge itself, by as many pixels as the board's scale gives; a
wrong response moves its middle and its flanks differently. So both are told apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special
from scipy.optimize import least_squares

from vision.calibration.board_edges import REACH_PX, BoardEdges
from vision.compression import code_smoothing
from vision.light import (
    CURVE_PARAMETERS,
    UNKNOWN_RESPONSE,
    NamedResponse,
    Response,
    ResponseCurve,
    half_level_share,
    light_of,
)
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
FIRST_DOUBT = 0.05  # of a bin's sum, in steps from black to white and roots of its pixels
MIDDLE_PX, FLANK_FACTOR = 0.5, 3.0  # away from half level compression does that much more
KNOWN_GAIN_MM = 1e-4  # compression bends flanks as a gain would: the printer is then taken to be right
SLOPE_STEP = 1e-3
USUAL_LIGHT = np.array([0.02, 0.9])  # of the background and of a bar, exposed as it should be
USUAL_BLUR_PX = 0.8
CODES = np.linspace(0.0, 1.1, 4401)
CONTRADICTION_PX = 0.04  # of a bar's edge: a standard that is off by less is taken at its word


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredResponse:
    """What the board pictures say of the camera's response.

    Attributes
    ----------
    curve : ResponseCurve
    gain_mm : float
        How far black squares reach over the corners' lines: positive where the printer's black runs.
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

    Least squares over exponent, offset, shoulder and printing gain. What compression leaves of the mean asymmetry
    counts as a doubt that all pictures share, beside their noise.

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
    doubt, values = np.full(FLANK_BINS, FIRST_DOUBT), np.clip(USUAL, LOWEST + SLOPE_STEP, HIGHEST - SLOPE_STEP)
    compressed = any(coding.compression != "none" for _, coding in pictures)
    for gain_is_known in (True, True, compressed):
        values = _fitted(flanks, values, doubt, gain_is_known=gain_is_known)
        doubt = _doubt(flanks, values)
    covariance = _covariance(flanks, values, doubt)
    exponent, offset, shoulder, gain_mm = values.tolist()
    size = len(CURVE_PARAMETERS)
    curve = ResponseCurve(exponent, offset, shoulder, covariance[:size, :size])
    return MeasuredResponse(curve, gain_mm, float(np.sqrt(covariance[size, size])), flanks.pictures)


def _doubt(flanks: "_Flanks", values: Array) -> Array:
    """Standard deviation of a bin's weighted asymmetry, shape (FLANK_BINS,): noise, and what all pictures share.

    What is left of the mean asymmetry after the fit is the work of compression or of a filter, which no response
    explains. It bends flanks more than it moves their middle, and the fit takes up a part of it there.
    """
    left = flanks.asymmetry(values)
    pixels = flanks.compared
    noise = float(np.sqrt(np.mean(left**2)))
    shared = float(np.sqrt(np.mean(((left * np.sqrt(pixels)).sum(axis=0) / pixels.sum(axis=0)) ** 2)))
    near = (np.arange(FLANK_BINS) + 0.5) * STEP_PX < MIDDLE_PX
    return np.hypot(noise, np.where(near, 1.0, FLANK_FACTOR) * shared * np.sqrt(pixels.sum(axis=0)))


def _fitted(flanks: "_Flanks", start: Array, doubt: Array, *, gain_is_known: bool) -> Array:
    u_usual = np.where([False, False, False, gain_is_known], KNOWN_GAIN_MM, U_USUAL)

    def residuals(values: Array) -> Array:
        return np.concatenate([(flanks.asymmetry(values) / doubt).ravel(), (values - USUAL) / u_usual])

    found = least_squares(
        residuals, start, bounds=(LOWEST, HIGHEST), x_scale=0.3 * U_USUAL, diff_step=SLOPE_STEP, max_nfev=12
    )
    return np.asarray(found.x, dtype=np.float64)


def _covariance(flanks: "_Flanks", values: Array, doubt: Array) -> Array:
    """What all pictures leave open together, and the scatter of the pictures' own wishes (a sandwich)."""
    steps = SLOPE_STEP * np.eye(len(values))
    slopes = np.stack(
        [(flanks.asymmetry(values + step) - flanks.asymmetry(values - step)) / (2 * SLOPE_STEP) for step in steps], -1
    )
    slopes /= doubt[:, None]
    left = flanks.asymmetry(values) / doubt
    wishes = np.einsum("gbp,gb->gp", slopes, left).reshape(-1, DIRECTIONS, len(values)).sum(axis=1)
    inverse = np.linalg.inv(np.einsum("gbp,gbq->pq", slopes, slopes) + np.diag(U_USUAL**-2.0))
    count = flanks.pictures
    return inverse + inverse @ (wishes.T @ wishes * count / (count - len(values))) @ inverse


@dataclass(frozen=True, eq=False)
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
    smoothing : float
        Mean share of `vision.compression.code_smoothing` over the pictures, of grey: a board has no colours.
    """

    code: Index
    unit: Array
    segment: Index
    bin: Index
    white: NDArray[np.bool_]
    black: NDArray[np.bool_]
    count: Index
    px_per_mm: Array
    smoothing: float

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
        code = _joined([one.code + start[coding] for one, coding in pictures]).astype(np.int64)
        distance = _joined([one.distance_px for one in edges]).astype(np.float64)
        number = np.repeat(np.arange(len(edges)), [len(one.code) for one in edges])
        named = number * 100_000 + _joined([one.segment for one in edges]).astype(np.int64)
        segment = np.unique(named, return_inverse=True)[1]
        group = DIRECTIONS * number + _joined([one.upright for one in edges]).astype(np.int64)
        used = _usable(unit[code], distance, segment)[segment]
        groups = DIRECTIONS * len(edges)
        place = np.clip(np.floor((distance + REACH_PX) / STEP_PX).astype(np.int64), 0, BINS - 1)
        bins = (group * BINS + place)[used]
        scale = np.bincount(group[used], _joined([one.px_per_mm for one in edges]).astype(np.float64)[used], groups)
        return cls(
            code=code[used],
            unit=unit,
            segment=segment[used],
            bin=bins,
            white=(distance > PLATEAU_PX)[used],
            black=(distance < -PLATEAU_PX)[used],
            count=np.bincount(bins, minlength=groups * BINS).reshape(groups, BINS).astype(np.int64),
            px_per_mm=scale / np.maximum(np.bincount(group[used], minlength=groups), 1),
            smoothing=float(
                np.mean([code_smoothing(replace(coding, samples="grey", mosaic=None))[0] for _, coding in pictures])
            )
            if pictures
            else 0.0,
        )

    def asymmetry(self, values: Array) -> Array:
        """y(d) + y(-d) - 1 after gain and compression, times the root of its pixels, shape (groups, FLANK_BINS).

        y is the light of a bin between the plateaus of its edges, 0 on black and 1 on white.
        """
        y = self._profiles(ResponseCurve(*values[: len(CURVE_PARAMETERS)].tolist()))
        slope = np.gradient(y, STEP_PX, axis=1)
        steep = slope[:, HALF:] + slope[:, :HALF][:, ::-1]
        moved_px = values[-1] * self.px_per_mm + self.compression_px
        off = y[:, HALF:] + y[:, :HALF][:, ::-1] - 1 + steep * moved_px[:, None]
        return off[:, :FLANK_BINS] * np.sqrt(self.compared)

    @cached_property
    def compression_px(self) -> float:
        """How far compression moves half level towards white: a share of where the middle of the codes lies."""
        y = self._profiles(ResponseCurve(1.0))
        mean = (y * self.count).sum(axis=0) / np.maximum(self.count.sum(axis=0), 1)
        at_edge, steep = 0.5 * (mean[HALF] + mean[HALF - 1]), (mean[HALF] - mean[HALF - 1]) / STEP_PX
        return self.smoothing * float((at_edge - 0.5) / steep)

    @property
    def compared(self) -> Index:
        """Pixels that a bin and its mirror image have at least, 0 for too few, shape (groups, FLANK_BINS)."""
        pixels = np.minimum(self.count[:, HALF:], self.count[:, :HALF][:, ::-1])[:, :FLANK_BINS]
        return np.where(pixels > LEAST_IN_BIN, pixels, 0)

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


class ChosenResponse(NamedTuple):
    """A rig's response, and what is to be said of it.

    Attributes
    ----------
    response : Response
    warning : str
        Empty where nothing is doubtful.
    """

    response: Response
    warning: str


def chosen_response(told: NamedResponse | None, measured: MeasuredResponse | None) -> ChosenResponse:
    """Response of a rig from what `board.json` tells and what the board pictures show.

    Parameters
    ----------
    told : {"srgb", "linear", "gamma 2.2"} or None
        Used where the pictures do not contradict it: a standard is then known better than they can tell.
    measured : MeasuredResponse or None
        Used without `told`, and against it where a bar's edge would lie elsewhere by more than
        `CONTRADICTION_PX` and by more than three times the standard uncertainty.

    Returns
    -------
    ChosenResponse
    """
    if measured is None:
        untold = "board.json tells no response, and too few board pictures have squares to measure it from"
        return ChosenResponse(UNKNOWN_RESPONSE, untold) if told is None else ChosenResponse(told, "")
    if told is None:
        return ChosenResponse(measured.curve, "")
    off_px, u_px = edge_shift_px(told, measured.curve)
    if abs(off_px) <= max(CONTRADICTION_PX, 3 * u_px):
        return ChosenResponse(told, "")
    way = "outwards" if off_px > 0 else "inwards"
    return ChosenResponse(
        measured.curve,
        f'board.json tells the response "{told}", which the board pictures contradict: it would move a bar\'s edges '
        f"{abs(off_px):.2f} px {way} (u = {u_px:.2f} px); the measured response is used",
    )


def edge_shift_px(told: Response, measured: ResponseCurve) -> tuple[float, float]:
    """How far a bar's edge moves outwards when it is decoded by a told response instead of the measured one.

    Returns
    -------
    tuple of float
        The shift of an edge of `USUAL_BLUR_PX` between `USUAL_LIGHT`, and the measured response's own uncertainty.
    """
    codes = np.interp(USUAL_LIGHT, light_of(CODES, measured), CODES)
    dark, bright = light_of(codes, told)
    half = np.interp(0.5 * (dark + bright), light_of(CODES, told), CODES)
    low, at, high = light_of(np.array([codes[0], half, codes[1]]), measured)
    share = (at - low) / (high - low)
    doubts = half_level_share(measured, USUAL_LIGHT[:1], USUAL_LIGHT[1:])
    u_px = USUAL_BLUR_PX * float(np.linalg.norm(doubts)) * np.sqrt(2 * np.pi)
    return -USUAL_BLUR_PX * float(special.ndtri(np.clip(share, 0.01, 0.99))), u_px
