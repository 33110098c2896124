"""A barrier's edge over rollers, beside which light changes from roller to gap and at the rollers' ends."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from vision.edges.subpixel import Crossings

Array = NDArray[np.float64]

BESIDE_OFFSETS_PX = np.arange(-43.0, -2.5, 0.5)  # on the conveyor, clear of the barrier's blur
STRIP_SAMPLES = 21  # chosen: 10 px; the strip beside the barrier may be the gap beside the rollers' ends
DARK_SHARE = 0.5  # chosen: a farther strip that is lighter than the darkest by half the barrier's step shows a bar
CHANGED_SHARE = 0.03  # chosen: of the barrier's step, by which light beside it changes along the line over rollers
SMOOTHED_ROWS = 9  # chosen: rows over which levels are averaged, so that noise moves no minimum
SMOOTHED_SAMPLES = 5  # chosen: and samples, 1.25 px
DARK_OFFSETS_PX, BRIGHT_OFFSETS_PX = (-5.0, -1.0), (1.0, 6.0)  # chosen: where the levels beside an edge are looked for


def rollers_show(beside: Array, step: float) -> bool:
    """Whether light beside a barrier changes along the line, from roller to gap, other than steadily.

    Parameters
    ----------
    beside : ndarray of float64, shape (rows, offsets)
        Light at `BESIDE_OFFSETS_PX` from the barrier's edge.
    step : float
        Of light at the edge.

    Returns
    -------
    bool
    """
    if len(beside) < SMOOTHED_ROWS or step <= 0:
        return False
    smooth = ndimage.uniform_filter1d(beside, SMOOTHED_ROWS, axis=0)
    place = np.linspace(-1, 1, len(smooth))
    darkest = float(np.median(smooth, axis=0).min())
    for last in range(smooth.shape[1], STRIP_SAMPLES - 1, -STRIP_SAMPLES + 1):
        strip = smooth[:, last - STRIP_SAMPLES : last]
        nearest = last == smooth.shape[1]
        if not nearest and float(np.median(strip, axis=0).max()) - darkest > DARK_SHARE * step:
            continue
        along = strip.mean(axis=1)
        along = along - np.polyval(np.polyfit(place, along, 1), place)
        if np.ptp(np.percentile(along, [10, 90])) > CHANGED_SHARE * step:
            return True
    return False


def crossings_beside_rollers(profile: Array, offsets_px: Array) -> Crossings:
    """Half level between the darkest light beside a barrier's edge and the brightest on the barrier, row by row.

    Parameters
    ----------
    profile : ndarray of float64, shape (rows, offsets)
        From the conveyor to the barrier.
    offsets_px : ndarray of float64, shape (offsets,)
        Evenly spaced, the edge near 0.

    Returns
    -------
    Crossings
        NaN where a row has none.
    """
    rows = np.arange(len(profile))
    smooth = ndimage.uniform_filter1d(profile, SMOOTHED_ROWS, axis=0, mode="nearest")
    smooth = ndimage.uniform_filter1d(smooth, SMOOTHED_SAMPLES, axis=1, mode="nearest")
    dark, bright = (
        pick(smooth[:, (offsets_px >= low) & (offsets_px <= high)], axis=1)
        for pick, (low, high) in ((np.min, DARK_OFFSETS_PX), (np.max, BRIGHT_OFFSETS_PX))
    )
    over = profile - (0.5 * (dark + bright))[:, None]
    rises = (over[:, :-1] < 0) & (over[:, 1:] >= 0)
    away = np.where(rises, np.abs(offsets_px[:-1]), np.inf)
    first = np.argmin(away, axis=1)
    below, above = over[rows, first], over[rows, first + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        place = offsets_px[first] + (offsets_px[1] - offsets_px[0]) * below / (below - above)
    return Crossings(np.where(rises.any(axis=1), place, np.nan), dark, bright)
