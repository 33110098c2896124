"""Whether a camera smooths or sharpens its pictures, seen on the boards.

A sharpened edge overshoots its plateaus, a blurred one never does. In pictures without loss the sensor's noise is new
in every pixel: smoothing makes neighbours alike, sharpening makes them unlike. Noise does not tell whether light or
code values were filtered. A filter of code values moves a board's edge as it moves a bar's, by the same share of the
way to the middle of the code values, so that the response that is measured with it in place makes up for it; one of
light moves neither (docs/studies/camera_light.json).
"""

from collections.abc import Sequence

from vision.calibration.board_edges import NO_NOISE, BoardEdges
from vision.sent_picture import Coding

LEAST_OVERSHOOT = 0.015  # chosen: of the step from black to white; compression leaves less
LEAST_CORRELATION = 0.03  # chosen: of neighbours' noise; a tenth of a Gaussian of 1 px makes it
LEAST_NOISE_CODES = 0.4  # less is hidden by the steps of the code values
LEAST_TRIPLES = 10_000


def filter_warning(pictures: Sequence[tuple[BoardEdges, Coding]], overshoot: float) -> str:
    """One sentence that names the filter; empty where the pictures show none.

    Parameters
    ----------
    pictures : sequence of (BoardEdges, Coding)
        Of boards.
    overshoot : float
        Of the mean edge over its plateaus, in code values, share of the step.
    """
    correlation = noise_correlation(pictures)
    if overshoot > LEAST_OVERSHOOT:
        seen = f"edges overshoot by {100 * overshoot:.0f} % of their step"
    elif abs(correlation) > LEAST_CORRELATION:
        seen = f"the noise of neighbouring pixels is correlated by {100 * correlation:+.0f} %"
    else:
        return ""
    kind = "smooths" if overshoot <= LEAST_OVERSHOOT and correlation > 0 else "sharpens"
    return (
        f"the camera {kind} its pictures ({seen}); a response measured with the filter makes up for it, so take boards "
        "and bars with the same setting, or switch the filter off"
    )


def noise_correlation(pictures: Sequence[tuple[BoardEdges, Coding]]) -> float:
    """Correlation of the noise of neighbouring pixels over that of pixels further apart, (8 r1 - 10 r2 + 2 r4) / 6.

    r1, r2 and r4 being the correlations of pixels 1, 2 and 4 apart, a second difference over d pixels has 6 - 8 r_d +
    2 r_2d times the variance of the noise; white noise gives 0.

    Parameters
    ----------
    pictures : sequence of (BoardEdges, Coding)

    Returns
    -------
    float
        0 where compression or a lack of noise hides it.
    """
    noise = [edges.noise for edges, coding in pictures if coding.compression == "none"]
    triples, next_to, apart = (sum(one[part] for one in noise) for part in range(len(NO_NOISE)))
    if triples < LEAST_TRIPLES or apart / triples < 6 * LEAST_NOISE_CODES**2:
        return 0.0
    return 1 - next_to / apart
