"""From code values back to linear light.

An edge lies where light is halfway between dark and bright. Halfway in code values lies elsewhere: left undecoded, the
diameter is off by 1 mm RMS (docs/studies/worth.json).

Code values count from 0 at the coding's black to 1 at its white. A camera's response is one of three standards, or a
curve that was measured from board pictures (`vision.calibration.response`), which carries its own uncertainty.
"""

from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy import special

from vision.order_statistics import median

CLIPPED_CODE = 250  # chosen: from this 8-bit code value on a channel counts as overexposed, its light as lost
NamedResponse = Literal["srgb", "linear", "gamma 2.2"]
NAMED_RESPONSES: tuple[NamedResponse, ...] = get_args(NamedResponse)

Array = NDArray[np.float64]

U_NAMED_EXPONENT = 0.01  # relative: how far a camera that follows a standard may be off it
CURVE_PARAMETERS = ("exponent", "offset", "shoulder")
SLOPE_STEP = 1e-3  # for derivatives by the curve's parameters


@dataclass(frozen=True, slots=True, eq=False)
class ResponseCurve:
    """A measured response.

    With v = ((c + offset) / (1 + offset))^exponent of a code value c, light is v / (1 + shoulder - shoulder v), less
    what it is at c = 0. sRGB is nearly exponent 2.4 and offset 0.055; a camera whose black is coded above 0 has a
    negative offset.

    Attributes
    ----------
    exponent : float
    offset : float
        Of code values.
    shoulder : float
        How strongly bright light is compressed; 0 for not at all.
    covariance : ndarray of float64, shape (3, 3)
        Of exponent, offset and shoulder (k = 1).
    """

    exponent: float
    offset: float = 0.0
    shoulder: float = 0.0
    covariance: Array = field(default_factory=lambda: np.zeros((3, 3)))

    def light(self, code: Array) -> Array:
        """Light, 1 at code 1, of code values.

        Parameters
        ----------
        code : ndarray of float64
            0 at black, 1 at white; values beyond 1 go on along the curve.
        """
        bottom = self._bent(np.zeros(1))
        return (self._bent(code) - bottom) / (1 - bottom)

    def _bent(self, code: Array) -> Array:
        root = np.maximum(code + self.offset, 0.0) / (1 + self.offset)
        v = root**self.exponent
        return v / (1 + self.shoulder - self.shoulder * v)

    @property
    def parameters(self) -> Array:
        """Exponent, offset and shoulder."""
        return np.array([self.exponent, self.offset, self.shoulder])

    def moved(self, change: Array) -> "ResponseCurve":
        """Return the curve after changes of its three parameters."""
        exponent, offset, shoulder = (self.parameters + change).tolist()
        return replace(self, exponent=exponent, offset=offset, shoulder=shoulder)


Response = NamedResponse | ResponseCurve

# Nothing is known of a camera's response but what cameras have: from linear to sRGB.
UNKNOWN_RESPONSE = ResponseCurve(1.9, 0.03, 0.1, np.diag([0.5, 0.03, 0.1]) ** 2)


def light_of(code: Array, response: Response) -> Array:
    """Linear light of code values.

    Parameters
    ----------
    code : ndarray of float64
        0 at black, 1 at white.
    response : {"srgb", "linear", "gamma 2.2"} or ResponseCurve
        How the camera coded light: IEC 61966-2-1, no coding, a power law, or a measured curve.

    Returns
    -------
    ndarray of float64, shape of `code`

    Raises
    ------
    ValueError
        `response` is a name that is none of the three.
    """
    if isinstance(response, ResponseCurve):
        return response.light(code)
    if response == "linear":
        return code
    positive = np.maximum(code, 0.0)
    if response == "gamma 2.2":
        return positive**2.2
    if response == "srgb":
        return np.where(code <= 0.04045, code / 12.92, ((positive + 0.055) / 1.055) ** 2.4)
    raise ValueError(f'response is {response!r}; allowed are "srgb", "linear", "gamma 2.2"')


def decoding_table(response: Response, bits: int = 8, black: int = 0, white: int | None = None) -> NDArray[np.float32]:
    """Linear light of every code value.

    Parameters
    ----------
    response : {"srgb", "linear", "gamma 2.2"} or ResponseCurve
    bits : int
        Of a code value.
    black, white : int
        Code values that stand for 0 and for 1; without `white` the largest one. Light below black is 0.

    Returns
    -------
    ndarray of float32, shape (2**bits,)

    Raises
    ------
    ValueError
        `response` is a name that is none of the three.
    """
    top = (1 << bits) - 1 if white is None else white
    code = np.maximum(np.arange(1 << bits) - black, 0) / (top - black)
    return light_of(code, response).astype(np.float32)


def half_level_share(response: Response, dark: Array, bright: Array) -> Array:
    """How the share of the bar in a pixel at half level changes with the response's parameters.

    Parameters
    ----------
    response : {"srgb", "linear", "gamma 2.2"} or ResponseCurve
    dark, bright : ndarray of float64, shape (n,)
        Light on either side of the edge as the response has it.

    Returns
    -------
    ndarray of float64, shape (n, p)
        One column for each independent doubt of one standard uncertainty: a standard's relative exponent, or the
        principal axes of a curve's covariance.
    """
    if not isinstance(response, ResponseCurve):
        k = 1 + U_NAMED_EXPONENT
        level = (0.5 * (dark**k + bright**k)) ** (1 / k)
        return ((level - dark) / (bright - dark) - 0.5)[:, None]
    grid = np.linspace(0.0, 1.25, 4096)
    light = response.light(grid)
    codes = np.interp(np.stack([dark, 0.5 * (dark + bright), bright]), light, grid)
    return np.stack([_share_change(response, codes, axis) for axis in _axes(response.covariance)], axis=-1)


def half_level_doubts_px(response: Response, levels: tuple[Array, Array], blur_px: float) -> Array:
    """How far half level of an edge moves for each independent doubt of the response.

    Parameters
    ----------
    response : {"srgb", "linear", "gamma 2.2"} or ResponseCurve
    levels : tuple of ndarray of float64, shape (n,)
        Light on the dark and on the bright side along the edge, of which the medians count.
    blur_px : float
        Standard deviation of the edge's blur.

    Returns
    -------
    ndarray of float64, shape (p,)
        See `half_level_share`.
    """
    dark, bright = (median(level) for level in levels)
    share = half_level_share(response, np.array([max(dark, 0.0)]), np.array([bright]))[0]
    return blur_px * special.ndtri(np.clip(0.5 + share, 0.01, 0.99))


def half_level_shift_px(response: Response, codes: tuple[Array, Array], blur_px: float) -> float:
    """How far half level of code values lies from half level of light, on the dark side of it.

    Parameters
    ----------
    response : {"srgb", "linear", "gamma 2.2"} or ResponseCurve
    codes : tuple of ndarray of float64, shape (n,)
        Code values, 0 to 1, on the dark and on the bright side along the edge, of which the medians count.
    blur_px : float
        Standard deviation of the edge's blur.
    """
    dark, bright = (median(code) for code in codes)
    low, half, high = light_of(np.array([dark, 0.5 * (dark + bright), bright]).clip(0.0, 1.0), response)
    return -blur_px * float(special.ndtri((half - low) / (high - low)))


def _axes(covariance: Array) -> Array:
    """Vectors of one standard uncertainty along the principal axes, shape (3, 3)."""
    variance, axes = np.linalg.eigh(covariance)
    return (axes * np.sqrt(np.maximum(variance, 0.0))).T


def _share_change(curve: ResponseCurve, codes: Array, axis: Array) -> Array:
    """Change of the share at the code of half level, per step along an axis, by central differences."""
    size = float(np.abs(axis).max())
    if size == 0.0:
        return np.zeros(codes.shape[1])
    step = min(1.0, SLOPE_STEP / size)
    shares: list[Array] = []
    for sign in (1.0, -1.0):
        low, half, high = curve.moved(sign * step * axis).light(codes)
        shares.append((half - low) / (high - low))
    return (shares[0] - shares[1]) / (2 * step)
