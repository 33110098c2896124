"""The inner faces of two barriers: their feet, and what the faces' widths tell of the camera's place.

Seen from above, a barrier's face shows as a strip of a pixel or two between its foot and its upper edge, two steps of
light in a profile across it. Both are fitted, blurred alike by the lens, to mean profiles of both barriers together.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from vision.sizing.conveyor.barriers import SAMPLE_OFFSETS_PX, Barriers, across

Array = NDArray[np.float64]

# Focal length over the picture's width where it is assumed: fields of view of 43 to 75 degrees, rectangular, chosen.
FOCAL_SHARE, U_FOCAL_SHARE = 0.95, 0.18
# Bounds of the fit of a barrier's foot: place px, slope px, light of face and of top, level of the conveyor.
LEAST_FOOT_VALUES, MOST_FOOT_VALUES = (-6.0, -2.0, 0.0, 0.0, -0.1), (3.0, 2.0, 2.0, 2.0, 0.1)
MOST_ACROSS_SHARE = 0.45  # chosen: a camera that sees both inner faces hangs at most 45 % of W off the middle
MOST_FACTOR = 2.0  # chosen: the fit may change the distance of a barrier's two edges by this factor
LEAST_STEP_SHARE = 0.15  # chosen: with a weaker second step of light nobody can say which edge the other one is
RESOLVED_BLURS = 1.0  # chosen: a face narrower than the blur looks like one step with more blur, and is not fitted
PROFILE_NOISE = 0.002  # chosen: noise of mean profiles, over full scale
SAMPLES_PER_PX = 1 / 0.25  # of a profile: neighbours share their noise
BAND_COUNT = 12  # chosen: bands of rows whose mean profiles are fitted
DARK_OFFSET_PX = 5.0  # chosen: this far inwards of a barrier's edge a pixel surely shows the conveyor


@dataclass(frozen=True, slots=True, eq=False)
class Feet:
    """Feet of both inner faces, and the camera's place by the faces' widths, with standard uncertainties.

    Attributes
    ----------
    lines : ndarray of float64, shape (2, 2)
        Slope and start of column(row) of the left and of the right foot.
    u_width_px : float
        Of their distance.
    part, u_part : float
        Width of both faces together over the barriers' distance; relative uncertainty.
    across, u_across : float
        Place of the middle between the barriers from straight below the camera, over their distance.
    face_px, blur_px : float
        Mean width of a face, and the lens's blur.
    weaker_step : float
        The weaker of a barrier's two steps of light over their sum, on the side where it is weaker.
    misfit : float
        Half the sum of squares.
    """

    lines: Array
    u_width_px: float
    part: float
    u_part: float
    across: float
    u_across: float
    face_px: float
    blur_px: float
    weaker_step: float
    misfit: float

    @property
    def show(self) -> bool:
        """Whether both steps of light show: a face wider than the blur, and no step too weak."""
        return self.face_px >= RESOLVED_BLURS * self.blur_px and self.weaker_step >= LEAST_STEP_SHARE


def fitted_feet(barriers: Barriers, part: float, across: float, u_across: float, *, free: bool) -> Feet:
    """Two steps of light a known distance apart, fitted to mean profiles of both barriers, blurred alike by the lens.

    Parameters
    ----------
    barriers : Barriers
    part : float
        Width of both faces together over the barriers' distance.
    across, u_across : float
        Place of the middle between the barriers from straight below the camera, over their distance, and its standard
        uncertainty.
    free : bool
        `part` is only roughly known: the profiles then tell it too.

    Returns
    -------
    Feet
    """
    sides = [_Steps.of(barriers, line, outwards, part) for line, outwards in zip(barriers.lines, (-1, 1), strict=True)]
    reach = MOST_FACTOR if free else 1 + 1e-9
    low = [1 / reach, -MOST_ACROSS_SHARE, 0.5, *LEAST_FOOT_VALUES, *LEAST_FOOT_VALUES]
    high = [reach, MOST_ACROSS_SHARE, 5.0, *MOST_FOOT_VALUES, *MOST_FOOT_VALUES]
    starts = [[1.0, place, 1.5, *sides[0].start(), *sides[1].start()] for place in (across, 0.0)]
    n, common = len(LEAST_FOOT_VALUES), 3

    def misfit(values: Array) -> Array:
        factor, place, blur_px = values[:common]
        by_side = zip(sides, values[common:].reshape(2, n), strict=True)
        fits = [side.misfit(one, blur_px, factor * (0.5 + side.outwards * place)) for side, one in by_side]
        known = [(factor - 1) / U_FOCAL_SHARE, (place - across) / u_across]  # prior where profiles hardly depend
        return np.concatenate([*fits, PROFILE_NOISE * np.array(known)])

    # from one start alone the fit may end with the two steps of a face in one
    tried = [optimize.least_squares(misfit, np.clip(start, low, high), bounds=(low, high)) for start in starts]
    found = min(tried, key=lambda fit: fit.cost)
    places = [common, common + n]
    lines = np.array([side.line_at(*found.x[first : first + 2]) for side, first in zip(sides, places, strict=True)])
    alike = SAMPLES_PER_PX * barriers.correlated_px
    covariance = alike * _covariance(found.fun, found.jac, slice(0 if free else 1, None))
    u_factor, u_place = np.sqrt(np.diag(covariance)[:2]).tolist()
    return Feet(
        lines=lines,
        u_width_px=float(np.sqrt(covariance[np.ix_(places, places)].sum())),
        part=part * float(found.x[0]),
        u_part=u_factor / float(found.x[0]),
        across=float(found.x[1]),
        u_across=u_place,
        face_px=float(found.x[0]) * float(np.mean([side.apart_px.mean() for side in sides])) / 2,
        blur_px=float(found.x[2]),
        weaker_step=min(float(min(one) / (sum(one) or 1.0)) for one in found.x[common:].reshape(2, n)[:, 2:4].tolist()),
        misfit=float(found.cost),
    )


def _covariance(misfit: Array, jacobian: Array, free: slice) -> Array:
    """Covariance of the free fitted values from the scatter of residuals that are independent; 0 for the others."""
    size = jacobian.shape[1]
    scatter = float(misfit @ misfit) / (misfit.size - size)
    covariance = np.zeros((size, size))
    covariance[free, free] = scatter * np.linalg.pinv(jacobian[:, free].T @ jacobian[:, free])
    return covariance


@dataclass(frozen=True, slots=True, eq=False)
class _Steps:
    """Mean profiles of one barrier in bands of rows, shape (bands, samples), with their rows and expected steps."""

    mean: Array
    line: Array
    outwards: int
    row: Array
    apart_px: Array

    @classmethod
    def of(cls, barriers: Barriers, line: Array, outwards: int, part: float) -> "_Steps":
        rows = np.arange(len(barriers.light), dtype=np.float64)
        profile = across(barriers.light, line, outwards, rows, SAMPLE_OFFSETS_PX)
        whole = np.isfinite(profile).all(axis=1)
        rows, profile = rows[whole], profile[whole]
        profile = profile - profile[:, SAMPLE_OFFSETS_PX < -DARK_OFFSET_PX].mean(axis=1, keepdims=True)
        row = np.array([band.mean() for band in np.array_split(rows, BAND_COUNT)])
        mean = np.array([band.mean(axis=0) for band in np.array_split(profile, BAND_COUNT)])
        return cls(mean, line, outwards, row, part * barriers.width_px(row) / np.hypot(1.0, line[0]))

    def start(self) -> list[float]:
        height = float(self.mean[:, -1].mean())
        return [-0.25 * float(self.apart_px.mean()), 0.0, 0.5 * height, 0.5 * height, 0.0]

    def misfit(self, values: Array, blur_px: float, share: float) -> Array:
        """Misfit of a foot's place and slope, the light of face and top, and the face's share of both faces' width."""
        place, slope, face, top, level = values
        along = (self.row - self.row.mean()) / np.ptp(self.row)
        at = SAMPLE_OFFSETS_PX - (place + slope * along)[:, None]
        steps = face * special.ndtr(at / blur_px) + top * special.ndtr((at - share * self.apart_px[:, None]) / blur_px)
        return (level + steps - self.mean).ravel()

    def line_at(self, place: float, slope: float) -> Array:
        """Line column(row) of the foot."""
        off = self.outwards * np.hypot(1.0, self.line[0])
        per_row = off * slope / np.ptp(self.row)
        return self.line + np.array([per_row, off * place - per_row * self.row.mean()])
