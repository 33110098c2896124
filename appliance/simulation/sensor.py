"""Lens blur and sensor: from linear light to the picture."""

import math
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.coding import jpeg
from appliance.simulation.response import Response, encode

Light = NDArray[np.float32]

Coding = Literal["lossless", "jpeg 4:4:4", "jpeg 4:2:0"]

LEVELS = 1 << 14
FINE_LEVELS = (1 << 16) - 1  # of light, for more than 8 bits
STEP_REACH = 6.0
STEP_PLACES = np.linspace(-STEP_REACH, STEP_REACH, 4801)
STEP = np.array([0.5 * math.erfc(-place / math.sqrt(2)) for place in STEP_PLACES])


@dataclass(frozen=True, slots=True)
class Blur:
    """Point spread function: a Gaussian core with a weak, wide Gaussian halo, pixel aperture included.

    Attributes
    ----------
    core_px, halo_px : float
        Standard deviations, pixels.
    halo_part : float
        Part of the light that goes into the halo.
    """

    core_px: float = 0.7
    halo_px: float = 5.0
    halo_part: float = 0.02

    def transfer(self, cycles_per_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Modulation transfer function."""
        square = -2 * (np.pi * cycles_per_px) ** 2
        core, halo = np.exp(square * self.core_px**2), np.exp(square * self.halo_px**2)
        return (1 - self.halo_part) * core + self.halo_part * halo


@dataclass(frozen=True, slots=True)
class Sensor:
    """Noise and response of the sensor.

    Attributes
    ----------
    response : str or ResponseShape
        How code values follow from light.
    full_well_electrons : float
        Electrons at full scale: the shot noise.
    read_noise_electrons : float
    bits : int
        Of a code value.
    """

    response: Response = "srgb"
    full_well_electrons: float = 10000.0
    read_noise_electrons: float = 12.0
    bits: int = 8

    def noise(self, light: Light) -> Light:
        """Standard deviation of the noise at each level of light (1 is full scale), in units of full scale."""
        variance = light / np.float32(self.full_well_electrons)
        variance += np.float32((self.read_noise_electrons / self.full_well_electrons) ** 2)
        return np.sqrt(variance, out=variance)

    @property
    def levels(self) -> int:
        """Equidistant levels of light above 0, up to full scale, that the response is tabulated at."""
        return LEVELS if self.bits == 8 else FINE_LEVELS

    def table(self) -> NDArray[np.uint8] | NDArray[np.uint16]:
        """Code value of each of `levels` + 1 levels of light from 0 to 1."""
        light = np.linspace(0.0, 1.0, self.levels + 1)
        values = np.rint(((1 << self.bits) - 1) * encode(light, self.response))
        return values.astype(np.uint8) if self.bits == 8 else values.astype(np.uint16)


def coded(picture: NDArray[np.uint8], coding: Coding, quality: int = 92) -> NDArray[np.uint8]:
    """Blue-green-red picture as it comes back from its coding; 4:2:0 halves the colour's resolution."""
    if coding == "lossless":
        return picture
    data = jpeg(picture, quality, "4:4:4" if coding == "jpeg 4:4:4" else "4:2:0")
    return np.asarray(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR), np.uint8)


def blurred_step(place: NDArray[np.floating]) -> Light:
    """A step from 0 to 1 behind a Gaussian blur, at distances from it in standard deviations of the blur."""
    return np.interp(place, STEP_PLACES, STEP).astype(np.float32)


class NoiseStock:
    """Standard normal noise made once and cut at a new place for each picture, which is fast.

    Parameters
    ----------
    shape : tuple of int
        Shape of a picture's noise.
    seed : int
    """

    EXTRA = 1 << 20

    def __init__(self, shape: tuple[int, ...], seed: int) -> None:
        self._shape = shape
        self._size = int(np.prod(shape))
        rng = np.random.default_rng([seed, 0x6E6F])
        self._stock = rng.standard_normal(self._size + self.EXTRA, dtype=np.float32)

    def cut(self, start: int) -> Light:
        """Noise from a place of the stock, 0 <= start < EXTRA; a view, do not write to it."""
        return self._stock[start : start + self._size].reshape(self._shape)
