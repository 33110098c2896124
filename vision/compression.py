"""What lossy compression does to an edge: it smooths code values, and an edge smoothed in code values moves.

A lens smooths light, and half level in light stays where it is. A codec takes away what is fine after the camera has
coded light, so a part of the edge's width comes from smoothing in code values, about whose own middle it is symmetric.
Decoded to light, half level then moves towards the bright side by a share of the distance between the two middles.
The share was measured on boards of the simulated mill, 0.7 to 0.9 px of blur, four cameras, as the move of half level
under the true response: 3 % for JPEG of quality 90, 8 % for 75; 3.5, 8 and 13.5 % for x264 at CRF 18, 23 and 28.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import special

from vision.light import Response, light_of
from vision.sent_picture import Coding

JPEG_SHARE = 0.3  # at quality 0, falling linearly to none at 100: 3 % at 90, 7.5 % at 75
JPEG_COLOUR_SHARE = 0.75  # of a single colour, which holds colour differences: JPEG quantises them more coarsely
USUAL_JPEG_QUALITY = 85  # of a file that does not tell
VIDEO_SHARE = 0.08  # at CRF 23; a stream does not tell how strongly it is compressed
# Relative standard uncertainties. The shares are known from our own mill alone; on line_r, another maker's JPEG of
# quality 95, the correction of 0.04 mm made the error larger (+0.06 to +0.09 mm), so it counts in full.
U_JPEG_SHARE, U_VIDEO_SHARE = 1.0, 0.5
CODES = np.linspace(0.0, 1.1, 2201)


def code_smoothing(coding: Coding) -> tuple[float, float]:
    """Share of the distance between the middles in code values and in light by which half level moves.

    Returns
    -------
    tuple of float
        The share, and its standard uncertainty.
    """
    if coding.compression == "none":
        return 0.0, 0.0
    if coding.compression == "video":
        return VIDEO_SHARE, U_VIDEO_SHARE * VIDEO_SHARE
    of_full = JPEG_COLOUR_SHARE if coding.samples == "colour" else JPEG_SHARE
    share = of_full * (1 - (coding.quality or USUAL_JPEG_QUALITY) / 100)
    return share, U_JPEG_SHARE * share


def middle_of_codes_px(response: Response, dark: float, bright: float, blur_px: float) -> float:
    """How far the middle in code values lies outside the middle in light, on an edge that a lens blurred.

    Parameters
    ----------
    response : Response
    dark, bright : float
        Light on either side.
    blur_px : float
        Standard deviation of the edge's blur.

    Returns
    -------
    float
        Pixels towards the dark side; 0 without a step.
    """
    if not 0.0 <= dark < bright:
        return 0.0
    light = light_of(CODES, response)
    middle = 0.5 * np.sum(np.interp([dark, bright], light, CODES))
    share = (float(np.interp(middle, CODES, light)) - dark) / (bright - dark)
    return float(-blur_px * special.ndtri(np.clip(share, 0.01, 0.99)))


def compression_shift_px(
    coding: Coding, response: Response, levels: tuple[NDArray[np.float64], NDArray[np.float64]], blur_px: float
) -> tuple[float, float]:
    """How far compression moved half level of an edge inwards.

    Parameters
    ----------
    coding : Coding
    response : Response
    levels : tuple of ndarray of float64, shape (n,)
        Light of the background and of the bar along the edge; NaN where unknown.
    blur_px : float

    Returns
    -------
    tuple of float
        Pixels, and their standard uncertainty.
    """
    share, u_share = code_smoothing(coding)
    dark, bright = (float(np.nanmedian(level)) if np.isfinite(level).any() else np.nan for level in levels)
    if share == 0.0 or not np.isfinite(dark + bright + blur_px):
        return 0.0, 0.0
    away_px = middle_of_codes_px(response, max(dark, 0.0), bright, blur_px)
    return share * away_px, u_share * abs(away_px)
