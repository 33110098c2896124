"""A section that is not round and turns: its mean diameter and its ovality from the widths of both views over time.

An ellipse of mean diameter D and ovality o (greatest minus least width) that turns shows each view the width
D + (o / 2) cos(w t + p), w twice the speed of the turn, p of each view. Least squares in D and both views' cosine and
sine for each w of a grid; the best w is kept if it stands out and the bar has shown all its widths.

p of the two views differs by twice the angle between them. A diameter that changes along the bar (a taper, a wave of
the rolls) changes both widths in phase and is no ovality: both waves must differ as those of a turn do.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_FRAMES = 12  # chosen: five unknowns and a speed take at least twelve pairs of widths
SPEEDS = 60  # chosen: speeds of the grid, from one wave of widths over all frames to a quarter of the frame rate
LEAST_SCATTER = 1.5  # chosen: noise alone scatters by 1, and the fits of all speeds take 3 ms
LEAST_WAVES = 1.0  # a whole wave: half a turn of the bar, after which all widths were seen
CLEAR_SIGMAS = 5.0  # chosen: an amplitude of fewer standard uncertainties may be chance, the best of `SPEEDS`
# Difference of both waves over the sum of their amplitudes: sin(angle between the views) for an ellipse that turns, 0
# for a diameter that changes along the bar. Chosen: views 15 degrees apart still show a turn.
LEAST_DIFFERENCE_SHARE = 0.25
LEAST_EXPLAINED_SHARE = 0.6  # chosen: share of the widths' variance that the turn must explain


@dataclass(frozen=True, slots=True)
class TurningSection:
    """Mean diameter and ovality of a section that has turned, mm, with their standard uncertainties."""

    diameter_mm: float
    u_diameter_mm: float
    ovality_mm: float
    u_ovality_mm: float


def turning_section(time_s: Array, width_mm: Array, noise_mm: float) -> TurningSection | None:
    """Fit a turning ellipse to widths.

    Parameters
    ----------
    time_s : ndarray of float64, shape (n,)
        Increasing.
    width_mm : ndarray of float64, shape (n, 2)
        Across the left and the right view; NaN where a view shows no width.
    noise_mm : float
        Standard uncertainty of a width of its own; widths that scatter by no more than `LEAST_SCATTER` of it are alike.

    Returns
    -------
    TurningSection or None
        None where the bar has not turned far enough or is too round to tell, and where both widths change in phase.
    """
    both = np.isfinite(width_mm).all(axis=1)
    time_s, width_mm = time_s[both] - (time_s[both][0] if both.any() else 0.0), width_mm[both]
    count = len(time_s)
    if count < LEAST_FRAMES or not time_s[-1] > 0:
        return None
    if width_mm.std() < LEAST_SCATTER * noise_mm:
        return None
    waves = np.linspace(LEAST_WAVES, max(LEAST_WAVES + 1, count / 4), SPEEDS)
    fits = [_fit(2 * math.pi * wave * time_s / time_s[-1], width_mm) for wave in waves]
    parameters, square, covariance = min(fits, key=lambda fit: fit[1])
    total = float(np.sum((width_mm - width_mm.mean()) ** 2))
    left, right = math.hypot(*parameters[1:3]), math.hypot(*parameters[3:5])
    u_amplitude = math.sqrt(float(np.mean(np.diag(covariance)[1:])))
    difference = math.hypot(parameters[1] - parameters[3], parameters[2] - parameters[4])
    clear = min(left, right) > CLEAR_SIGMAS * u_amplitude
    clear = clear and difference > max(
        CLEAR_SIGMAS * math.sqrt(2) * u_amplitude, LEAST_DIFFERENCE_SHARE * (left + right)
    )
    if not clear or square > (1 - LEAST_EXPLAINED_SHARE) * total:
        return None
    return TurningSection(
        diameter_mm=float(parameters[0]),
        u_diameter_mm=math.sqrt(float(covariance[0, 0])),
        ovality_mm=left + right,
        u_ovality_mm=math.hypot(math.sqrt(2) * u_amplitude, (left - right) / 2),
    )


def _fit(phase: Array, width_mm: Array) -> tuple[Array, float, Array]:
    """Parameters D, cosine and sine of the left, of the right view; sum of squared residuals; covariance."""
    one, none = np.ones_like(phase), np.zeros_like(phase)
    wave = np.column_stack([np.cos(phase), np.sin(phase)])
    nothing = np.column_stack([none, none])
    design = np.concatenate([np.column_stack([one, wave, nothing]), np.column_stack([one, nothing, wave])])
    seen = width_mm.T.ravel()
    parameters = np.asarray(np.linalg.lstsq(design, seen, rcond=None)[0], np.float64)
    square = float(np.sum((seen - design @ parameters) ** 2))
    variance = square / max(len(seen) - 6, 1)
    return parameters, square, np.asarray(variance * np.linalg.pinv(design.T @ design), np.float64)
