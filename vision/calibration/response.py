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
from scipy.sparse import csr_array

from vision.calibration.board_edges import REACH_PX, BoardEdges
from vision.calibration.camera_filter import filter_warning
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
OVERSHOOT_PX = 1.0  # from an edge: nearer there is no overshoot
FLANK_BINS = round(3.0 / STEP_PX)  # bins that are compared; further out are the plateaus
PLATEAU_PX = 3.0
BLACK_BINS, WHITE_BINS = (
    slice(0, round((REACH_PX - PLATEAU_PX) / STEP_PX)),
    slice(round((REACH_PX + PLATEAU_PX) / STEP_PX), BINS),
)
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
    filter : str
        A sentence about the camera's smoothing or sharpening; empty where the pictures show none.
    """

    curve: ResponseCurve
    gain_mm: float
    u_gain_mm: float
    pictures: int
    filter: str = ""


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
    found = filter_warning(pictures, flanks.overshoot)
    return MeasuredResponse(curve, gain_mm, float(np.sqrt(covariance[size, size])), flanks.pictures, found)


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
    unit : ndarray of float64
        Code value, 0 to 1, of each place in the tables of all codings, one after the other.
    pixels : csr_array of float64, shape (segments * BINS, places)
        Pixels of a segment's bin with the code value of a place.
    segments : csr_array of float64, shape (groups, segments)
        1 where a segment belongs to a group.
    px_per_mm : ndarray of float64, shape (groups,)
    codings : list of Coding
        Of the pictures.
    """

    unit: Array
    pixels: csr_array
    segments: csr_array
    px_per_mm: Array
    codings: list[Coding]

    @property
    def pictures(self) -> int:
        """Pictures with any edge that counts."""
        return int(np.count_nonzero(self.count.reshape(-1, DIRECTIONS * BINS).any(axis=1)))

    @cached_property
    def of_segment(self) -> Array:
        """Pixels of each segment's bins, shape (segments, BINS)."""
        return self.pixels.sum(axis=1).reshape(-1, BINS)

    @cached_property
    def count(self) -> Array:
        """Pixels of each group's bins, shape (groups, BINS)."""
        return self.segments @ self.of_segment

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
        group = DIRECTIONS * number + _joined([one.upright for one in edges]).astype(np.int64)
        named = group * 100_000 + _joined([one.segment for one in edges]).astype(np.int64)
        used = _usable(unit[code], distance, np.unique(named, return_inverse=True)[1])
        names, segment = np.unique(named[used], return_inverse=True)
        place = np.clip(np.floor((distance[used] + REACH_PX) / STEP_PX).astype(np.int64), 0, BINS - 1)
        groups = DIRECTIONS * len(edges)
        scale = np.bincount(group[used], _joined([one.px_per_mm for one in edges]).astype(np.float64)[used], groups)
        return cls(
            unit=unit,
            pixels=_counted(segment * BINS + place, code[used], (len(names) * BINS, len(unit))),
            segments=_counted(names // 100_000, np.arange(len(names)), (groups, len(names))),
            px_per_mm=scale / np.maximum(np.bincount(group[used], minlength=groups), 1),
            codings=[coding for _, coding in pictures],
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
        mean = self._mean_of_codes
        at_edge, steep = 0.5 * (mean[HALF] + mean[HALF - 1]), (mean[HALF] - mean[HALF - 1]) / STEP_PX
        black, white = self._plateaus(self._light(ResponseCurve(1.0)))
        step, blur_px = float(np.mean(white - black)), float(1 / (np.sqrt(2 * np.pi) * steep))
        shares = [
            # a board has no colours, and so the whole of its picture is in luma
            code_smoothing(replace(one, samples="grey", mosaic=None), step * one.span_codes, blur_px)[0]
            for one in self.codings
        ]
        return float(np.mean(shares) * (at_edge - 0.5) / steep)

    @cached_property
    def _mean_of_codes(self) -> Array:
        """Mean profile of all edges in code values, 0 on black and 1 on white, shape (BINS,)."""
        y = self._profiles(ResponseCurve(1.0))
        return (y * self.count).sum(axis=0) / np.maximum(self.count.sum(axis=0), 1)

    @property
    def overshoot(self) -> float:
        """How far the mean edge rises over its plateaus beside them, share of the step in code values."""
        mean = self._mean_of_codes
        beside = slice(HALF + round(OVERSHOOT_PX / STEP_PX), WHITE_BINS.start)
        return max(float(np.max(mean[beside]) - 1), float(-np.min(mean[::-1][beside])), 0.0)

    @property
    def compared(self) -> Array:
        """Pixels that a bin and its mirror image have at least, 0 for too few, shape (groups, FLANK_BINS)."""
        pixels = np.minimum(self.count[:, HALF:], self.count[:, :HALF][:, ::-1])[:, :FLANK_BINS]
        return np.where(pixels > LEAST_IN_BIN, pixels, 0)

    def _light(self, curve: ResponseCurve) -> Array:
        """Light summed over the pixels of each segment's bins, shape (segments, BINS)."""
        return (self.pixels @ curve.light(self.unit)).reshape(-1, BINS)

    def _plateaus(self, light: Array) -> tuple[Array, Array]:
        """Mean light of each segment's black and white side."""
        black, white = (
            light[:, side].sum(axis=1) / self.of_segment[:, side].sum(axis=1) for side in (BLACK_BINS, WHITE_BINS)
        )
        return black, white

    def _profiles(self, curve: ResponseCurve) -> Array:
        light = self._light(curve)
        black, white = self._plateaus(light)
        share = (light - black[:, None] * self.of_segment) / (white - black)[:, None]
        return (self.segments @ share) / np.maximum(self.count, 1)


def _joined(parts: list[Array] | list[Index] | list[NDArray[np.bool_]]) -> NDArray[np.generic]:
    return np.concatenate(parts) if parts else np.empty(0, np.int64)


def _counted(row: Index, column: Index, shape: tuple[int, int]) -> csr_array:
    """How often each row and column occur together."""
    return csr_array((np.ones(len(row)), (row, column)), shape=shape)


def _usable(code: Array, distance: Array, segment: Index) -> NDArray[np.bool_]:
    """Pixels of segments with enough of both plateaus, white above black and not overexposed."""
    size = int(segment.max()) + 1 if segment.size else 0
    sides = [distance > PLATEAU_PX, distance < -PLATEAU_PX]
    count = [np.bincount(segment[side], minlength=size) for side in sides]
    white, black = (
        np.bincount(segment[side], code[side], size) / np.maximum(n, 1) for side, n in zip(sides, count, strict=True)
    )
    return ((np.minimum(*count) > LEAST_PLATEAU) & (white < CLIPPED_CODE) & (white > black))[segment]


class ChosenResponse(NamedTuple):
    """A rig's response, and what is to be said of it.

    Attributes
    ----------
    response : Response
    warning : str
        Empty where nothing is doubtful.
    filter : str
        As in `MeasuredResponse`.
    """

    response: Response
    warning: str = ""
    filter: str = ""


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
        return ChosenResponse(UNKNOWN_RESPONSE, untold) if told is None else ChosenResponse(told)
    off_px, u_px = (0.0, 0.0) if told is None else edge_shift_px(told, measured.curve)
    if abs(off_px) <= max(CONTRADICTION_PX, 3 * u_px):
        return ChosenResponse(measured.curve if told is None else told, filter=measured.filter)
    way = "outwards" if off_px > 0 else "inwards"
    return ChosenResponse(
        measured.curve,
        f'board.json tells the response "{told}", which the board pictures contradict: it would move a bar\'s edges '
        f"{abs(off_px):.2f} px {way} (u = {u_px:.2f} px); the measured response is used",
        measured.filter,
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
