"""What lossy compression does to an edge: it smooths code values, and an edge smoothed in code values moves.

A lens smooths light, and half level in light stays where it is. A codec takes away what is fine after the camera has
coded light, so a part of the edge's width comes from smoothing in code values, about whose own middle it is symmetric.
Decoded to light, half level then moves towards the bright side by a share of the distance between the two middles.

The share is k (q / A)^p exp(-c (s - 0.8)), q being the quantiser's step and A the edge's in code values, s the blur of
the lens in pixels: the coarser the quantiser against the edge and the finer the edge, the more is lost. The law and its
doubt are judged on drawn edges that real coders coded (docs/studies/compression.json): JPEG of quality 50 to 95 by
libjpeg, H.264 of CRF 18 to 28 by x264, whose blocks with edges have quantisers of 25 to 35. k, p and c of JPEG_COLOUR
are that study's fit. Those of JPEG and VIDEO are of an earlier fit to such edges, which was not kept; the study fits
1.19, 1.41, 2.94 and 0.87, 1.37, 1.01. Shares scatter about the constants below by 32 and 58 %; U counts 35 and 60 %.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special

from vision.light_planes import LightPlane
from vision.order_statistics import median_without_nan
from vision.sent_picture import Coding

Array = NDArray[np.float64]


class CodeSmoothing(NamedTuple):
    """How much of an edge's width a codec makes: factor k, power p and slope c."""

    factor: float
    power: float
    slope_per_px: float


JPEG = CodeSmoothing(0.91, 1.26, 2.9)
JPEG_COLOUR = CodeSmoothing(0.86, 0.78, 1.8)  # a single colour holds colour differences, which JPEG quantises coarsely
VIDEO = CodeSmoothing(0.67, 1.27, 0.73)
USUAL_BLUR_PX = 0.8
INTERPOLATION_VARIANCE_PX2 = 1 / 6  # of linear interpolation between pixels, over all places between them
LARGEST_SHARE = 0.5
# Place of a whole straight edge, standard deviation over q / A, pixels (docs/studies/coded_edges.json): JPEG rounds
# to either side; x264 also leaves out what it deems invisible, predicts blocks from their neighbours and smooths them.
PLACE_JPEG_PX, PLACE_VIDEO_PX = 0.2, 0.8
CROSSED_POWER = 0.75  # of the blocks that a slanted edge crosses, by which that falls
BLOCK_PX = 8  # side of a transform block (ITU-T T.81, H.264)
TOGETHER_PX = 4.0  # over which errors of a coder go together: side of H.264's smallest block
JPEG_STEP = 24.0  # of the luma table at quality 50: its middle frequencies (ITU-T T.81, K.1)
USUAL_JPEG_QUALITY = 85  # of a file that does not tell
USUAL_QUANTISER = 30  # of a stream that does not tell: at edges, about CRF 23
# Relative standard uncertainties: how far the shares of single edges scatter about the law in that study.
U_JPEG_SHARE, U_VIDEO_SHARE, U_UNTOLD_SHARE = 0.35, 0.6, 0.7  # the last without a known quantiser
# On line_r, another maker's JPEG of quality 95 in whole colours, the correction of 0.02 mm makes the errors larger,
# from 0.06 and 0.03 to 0.08 and 0.05 mm: it counts in full.
U_COLOUR_SHARE = 1.0


def quantiser_step(coding: Coding) -> float:
    """Step of the quantiser in code values of 8 bits; 0 where nothing is lost."""
    if coding.compression == "jpeg":
        quality = coding.quality or USUAL_JPEG_QUALITY
        return JPEG_STEP * (2 - quality / 50 if quality >= 50 else 50 / quality)
    if coding.compression == "video":
        quantiser = USUAL_QUANTISER if coding.quantiser is None else coding.quantiser
        return 0.625 * 2 ** (quantiser / 6)  # ITU-T H.264, 8.5.9: it doubles every 6
    return 0.0


def code_smoothing(coding: Coding, step_codes: float, blur_px: float) -> tuple[float, float]:
    """Share of the distance between the middles in code values and in light by which half level moves.

    Parameters
    ----------
    coding : Coding
    step_codes : float
        Of the edge, in code values of 8 bits.
    blur_px : float
        Standard deviation of the lens' blur.

    Returns
    -------
    tuple of float
        The share, and its standard uncertainty; 0 without an edge.
    """
    step = quantiser_step(coding)
    if step == 0.0 or not step_codes > 0.0:
        return 0.0, 0.0
    law = {"jpeg": JPEG_COLOUR if coding.samples == "colour" else JPEG}.get(coding.compression, VIDEO)
    share = law.factor * (step / step_codes) ** law.power * np.exp(-law.slope_per_px * (blur_px - USUAL_BLUR_PX))
    share = min(float(share), LARGEST_SHARE)
    if law is JPEG_COLOUR:
        return share, U_COLOUR_SHARE * share
    if coding.compression == "video":
        return share, share * (U_UNTOLD_SHARE if coding.quantiser is None else U_VIDEO_SHARE)
    return share, share * (U_UNTOLD_SHARE if coding.quality is None else U_JPEG_SHARE)


def u_place_px(coding: Coding, step_codes: float, crossed_px: float) -> float:
    """Standard uncertainty of the place of a whole edge by what a coder left out of it.

    Errors repeat where the edge lies alike in its blocks; a slanted edge passes through all places, and they average
    out over the blocks that it crosses.

    Parameters
    ----------
    coding : Coding
    step_codes : float
        Of the edge, in code values of 8 bits.
    crossed_px : float
        By which the edge leans from end to end: columns that an upright edge crosses.

    Returns
    -------
    float
        Pixels; 0 without compression, infinite without an edge.
    """
    if coding.compression == "none":
        return 0.0
    if not step_codes > 0.0:
        return float("inf")
    factor_px = PLACE_JPEG_PX if coding.compression == "jpeg" else PLACE_VIDEO_PX
    return factor_px * quantiser_step(coding) / step_codes * float(1 + crossed_px / BLOCK_PX) ** -CROSSED_POWER


def correlated_px(coding: Coding) -> float:
    """Distance over which errors of a picture go together: of neighbouring pixels, or of a coder's block."""
    return 1.0 if coding.compression == "none" else TOGETHER_PX


def step_codes(coding: Coding, plane: LightPlane, levels: tuple[Array, Array]) -> float:
    """Step of an edge in code values of 8 bits; NaN where it is unknown.

    Parameters
    ----------
    coding : Coding
    plane : LightPlane
        In which the edge was located.
    levels : tuple of ndarray of float64, shape (n,)
        Light on its dark and on its bright side; NaN where unknown.
    """
    return float(np.diff(_codes(plane, _medians(levels)))[0]) / 2 ** (coding.bits - 8)


def _medians(levels: tuple[Array, Array]) -> Array:
    return np.array([median_without_nan(level) if np.isfinite(level).any() else np.nan for level in levels])


def _codes(plane: LightPlane, light: Array) -> Array:
    return np.interp(light, plane.table[0], np.arange(len(plane.table[0])))


def compression_shift_px(
    coding: Coding, plane: LightPlane, levels: tuple[Array, Array], blur_px: float
) -> tuple[float, float]:
    """How far compression moved half level of an edge inwards.

    Parameters
    ----------
    coding : Coding
    plane : LightPlane
        In which the edge was located.
    levels : tuple of ndarray of float64, shape (n,)
        Light of the background and of the bar along the edge; NaN where unknown.
    blur_px : float
        Standard deviation of the edge's blur between pixels, interpolation included.

    Returns
    -------
    tuple of float
        Pixels, and their standard uncertainty.
    """
    if coding.compression == "none":
        return 0.0, 0.0
    dark, bright = _medians(levels).tolist()
    if not (dark < bright and np.isfinite(blur_px)):
        return 0.0, 0.0
    codes = _codes(plane, np.array([dark, bright]))
    middle = np.interp(codes.mean(), np.arange(len(plane.table[0])), plane.table[0])
    lens_px = float(np.sqrt(max(blur_px**2 - INTERPOLATION_VARIANCE_PX2, 0.0)))
    share, u_share = code_smoothing(coding, step_codes(coding, plane, levels), lens_px)
    away_px = float(-lens_px * special.ndtri(np.clip((middle - dark) / (bright - dark), 0.01, 0.99)))
    return share * away_px, u_share * abs(away_px)
