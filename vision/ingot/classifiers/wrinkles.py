"""Wrinkles of an ingot's end, which a top has and a bottom has not, and the odds of a top against a bottom.

A top has a smooth rim around skin that is wrinkled all over; a bottom is smooth, or has single flakes and scratches.
All measures are of the logarithm of the grey values, so that a change of light cancels; slow changes over the face are
subtracted first. Measures that depend on the camera are compared with those of the references.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.ingot.classifiers.classifier import Face, FaceClassifier, Verdict
from vision.ingot.classifiers.similarity import SIZE

Array = NDArray[np.float64]
Plane = NDArray[np.float32]

DARK_CODE = 4.0  # chosen: added to grey values before their logarithm, which is -infinity at 0
FACE_RADIUS = 0.7  # chosen, of the end's radius: inside lie no rim and no edge
SCALES_PX = (0.8, 1.6, 3.2)  # standard deviations of the Gaussians between which wrinkles lie
INTEGRATION_PX = 2.0  # of the structure tensor
DIRECTION_COUNT, RADIUS_COUNT = 72, 32  # of the polar picture
RIM_RADII = np.arange(19, 28)  # where a rim may begin, in steps of 1 / RADIUS_COUNT of the radius
LEAST_SPREAD = 0.01  # chosen: added to the spread of a rim's step over the directions, which may be 0
LEAST_STRENGTH = 1e-3  # chosen: added to strengths before their logarithm

MEASURES = ("rim", "fine", "coarse", "coherence", "sparseness", "rim_evenness")
RELATIVE = np.array([1, 1, 1, 0, 0, 0])  # to the mean of both references

# Logistic regression on the simulated ingot line, seeds 10000 and up (`python -m appliance.training.ingot_faces`):
# of each measure the mean, the standard deviation and the weight in natural logarithms of odds; the constant.
MEAN = np.array([-0.005408, 0.07262, 0.1583, 0.5769, 1.478, 1.332])
DEVIATION = np.array([0.04181, 0.6474, 0.658, 0.1412, 0.695, 1.318])
WEIGHT = np.array([1.415, 3.924, -3.664, 3.071, -5.211, 2.172])
CONSTANT = 0.5473
LARGEST_DEVIATION = 3.0  # chosen: a measure further from its mean counts as 3 standard deviations

_across = (np.arange(SIZE) - (SIZE - 1) / 2) / (SIZE / 2)
_x, _y = np.meshgrid(_across, _across)
_face = np.hypot(_x, _y) < FACE_RADIUS
_inner = np.hypot(_x, _y) < FACE_RADIUS - 0.08
_weight = _face.astype(np.float32)
_slow = np.stack([np.ones_like(_x), _x, _y, _x * _x, _x * _y, _y * _y], axis=-1)
_slow_fit = np.linalg.pinv(_slow[_face])
_angle = np.arange(DIRECTION_COUNT)[:, None] * 2 * np.pi / DIRECTION_COUNT
_radius = (np.arange(RADIUS_COUNT) + 0.5) / RADIUS_COUNT * SIZE / 2
_polar_x = ((SIZE - 1) / 2 + _radius * np.cos(_angle)).astype(np.float32)
_polar_y = ((SIZE - 1) / 2 + _radius * np.sin(_angle)).astype(np.float32)
_cover = [np.maximum(cv2.GaussianBlur(_weight, (0, 0), sigma), 0.05) for sigma in SCALES_PX]


def measures(image: NDArray[np.uint8]) -> Array:
    """The six measures of an end.

    Parameters
    ----------
    image : ndarray of uint8, shape (64, 64)
        As `end_image` gives it.

    Returns
    -------
    ndarray of float64, shape (6,)
        In the order of `MEASURES`: `rim`, step from the face to the rim (lower quartile over the directions); `fine`
        and `coarse`, logarithm of the strength of wrinkles of two widths; `coherence` of their direction, 0 to 1;
        `sparseness`, logarithm of the kurtosis, large for single flakes; `rim_evenness`, mean step over its spread.
    """
    light = np.log(image.astype(np.float32) + np.float32(DARK_CODE))
    rim, evenness = _rim(light)
    wide, narrow, base = _smoothed(light)
    fine, coarse = (wide - narrow)[_face], (narrow - base)[_face]
    return np.array([rim, _strength(fine), _strength(coarse), _coherence(wide - base), _sparseness(fine), evenness])


def _rim(light: Plane) -> tuple[float, float]:
    """Largest step of brightness outwards at one radius, as its lower quartile and as mean over spread."""
    polar = cv2.remap(light, _polar_x, _polar_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    around = np.pad(polar, ((4, 4), (0, 0)), mode="wrap")
    smooth = cv2.blur(around, (1, 9))[4:-4].astype(float)
    sums = np.cumsum(np.pad(smooth, ((0, 0), (1, 0))), axis=1)
    outer = (sums[:, RIM_RADII + 4] - sums[:, RIM_RADII + 1]) / 3
    inner = (sums[:, RIM_RADII - 1] - sums[:, RIM_RADII - 5]) / 4
    steps = (outer - inner).T
    quartile = np.percentile(steps, 25, axis=1)
    best = steps[int(np.argmax(quartile))]
    mean = steps.mean(axis=1)
    evenest = steps[int(np.argmax(mean))]
    return float(np.percentile(best, 25)), float(evenest.mean() / (evenest.std() + LEAST_SPREAD))


def _smoothed(light: Plane) -> list[Plane]:
    """The face without its slow changes, smoothed at each scale."""
    face = np.zeros_like(light)
    face[_face] = light[_face] - _slow[_face] @ (_slow_fit @ light[_face])
    return [
        np.asarray(cv2.GaussianBlur(face, (0, 0), sigma) / cover, np.float32)
        for sigma, cover in zip(SCALES_PX, _cover, strict=True)
    ]


def _strength(values: Plane) -> float:
    return float(np.log(np.median(np.abs(values - np.median(values))) + LEAST_STRENGTH))


def _sparseness(values: Plane) -> float:
    centred = values.astype(float) - values.mean()
    return float(np.log(np.mean(centred**4) / max(np.mean(centred**2), LEAST_STRENGTH**4) ** 2 + LEAST_STRENGTH))


def _coherence(wrinkles: Plane) -> float:
    """How far the gradients around a point agree in direction, mean over the face weighted by their strength."""
    x, y = (cv2.Sobel(wrinkles, cv2.CV_32F, *order) * _inner for order in ((1, 0), (0, 1)))
    xx, yy, xy = (cv2.GaussianBlur(product, (0, 0), INTEGRATION_PX)[_inner] for product in (x * x, y * y, x * y))
    return float(np.sqrt((xx - yy) ** 2 + 4 * xy**2).sum() / max(float((xx + yy).sum()), LEAST_STRENGTH**4))


class WrinkleOdds(FaceClassifier):
    """Odds that an end is a top, from its measures and those of two references.

    Parameters
    ----------
    top, bottom : ndarray of uint8, shape (64, 64)
        References.
    """

    def __init__(self, top: NDArray[np.uint8], bottom: NDArray[np.uint8]) -> None:
        self._reference = RELATIVE * (measures(top) + measures(bottom)) / 2

    def relative(self, image: NDArray[np.uint8]) -> Array:
        """The six measures, those that depend on the camera relative to the references."""
        return measures(image) - self._reference

    def log_odds(self, image: NDArray[np.uint8]) -> float:
        """Natural logarithm of the odds of a top against a bottom."""
        standard = np.clip((self.relative(image) - MEAN) / DEVIATION, -LARGEST_DEVIATION, LARGEST_DEVIATION)
        return float(standard @ WEIGHT + CONSTANT)

    def judge(self, face: Face) -> Verdict:
        """Top where the odds are in its favour."""
        log_odds = self.log_odds(face.image)
        return Verdict("top" if log_odds > 0 else "bottom", log_odds)
