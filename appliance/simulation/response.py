"""How a camera turns light into code values: the responses of standards, and ones of random shape."""

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray

NamedResponse = Literal["srgb", "linear", "gamma 2.2"]
Values = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ResponseShape:
    """A response that no standard describes.

    Attributes
    ----------
    exponent : float
        Code values follow light to the power 1 / exponent, at least 1.
    toe : float
        As a in (1 + a) L^(1/g) - a, continued to black by its tangent: 0.055 in sRGB, 0.099 in BT.709.
    shoulder : float
        k in (1 + k) L / (1 + k L): bright light is compressed.
    black : float
        Code value, 0 to 1, of no light.
    """

    exponent: float
    toe: float = 0.0
    shoulder: float = 0.0
    black: float = 0.0

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> Self:
        """Response of random shape: from linear to steeper than sRGB, with toe, shoulder and black level."""
        exponent = float(rng.uniform(1.0, 2.6))
        return cls(
            exponent=exponent,
            toe=float(rng.uniform(0.0, 0.1)) if exponent > 1.8 else 0.0,
            shoulder=float(rng.choice([0.0, rng.uniform(0.0, 0.5)])),
            black=float(rng.choice([0.0, rng.uniform(0.0, 0.03)])),
        )

    def encode(self, light: Values) -> Values:
        """Encoded value, 0 to 1, of linear light, 0 to 1."""
        bent = (1 + self.shoulder) * light / (1 + self.shoulder * light)
        code = (1 + self.toe) * bent ** (1 / self.exponent) - self.toe
        if self.toe > 0:
            root = self.toe / ((1 + self.toe) * (1 - 1 / self.exponent))  # of the light where the tangent leaves
            slope = ((1 + self.toe) * root - self.toe) / root**self.exponent
            code = np.where(bent < root**self.exponent, slope * bent, code)
        return self.black + (1 - self.black) * code


Response = NamedResponse | ResponseShape


def encode(light: Values, response: Response) -> Values:
    """Encoded value, 0 to 1, of linear light, 0 to 1; sRGB after IEC 61966-2-1.

    Parameters
    ----------
    light : ndarray of float64
    response : str or ResponseShape
    """
    if isinstance(response, ResponseShape):
        return response.encode(light)
    if response == "linear":
        return light
    if response == "gamma 2.2":
        return light ** (1 / 2.2)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
