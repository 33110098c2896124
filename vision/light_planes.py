"""Which code values of a picture locate an edge, and the light that each of them stands for.

A colour picture has one plane a channel, and the brightest channel that is not overexposed is the best. Luma is one
plane of all channels together, each coded on its own: Y' = sum of w_c f(L_c). Across the edge of a bar every channel's
light goes the same way from background to bar, L_c = D_c + s (B_c - D_c), s being the share of the bar in the pixel;
with the colours of both plateaus known, luma therefore tells s, and with it the light of the brightest channel. The
sites of a Bayer mosaic tell s likewise, each by its own channel.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.light import CLIPPED_CODE, Response, decoding_table, light_of
from vision.sent_picture import Codes, Coding

Array = NDArray[np.float64]
Table = NDArray[np.float32]

SHARES = np.linspace(-0.5, 2.0, 501)  # of the bar in a pixel: noise, and what is darker or brighter than its plateau
CURVE_CODES = np.linspace(0.0, 1.0, 2049)
LEAST_STEP = 0.02  # of the brightest channel's step: a channel with less says nothing of the share
EXCESSES = np.geomspace(1.0, 5.0, 24)  # light of an overexposed channel over what it shows
READ_NOISE = 0.02  # light whose shot noise equals the sensor's own
BLUE, GREEN, RED = range(3)
ONE_SITE = np.ones(1, np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class LightPlane:
    """Light of the code values of one channel, or of a mosaic.

    Attributes
    ----------
    channel : int
        Of `SentPicture.measured`.
    table : ndarray of float32, shape (sites, codes)
        Light of every code value; four sites (row and column even or odd) of a mosaic, else one.
    weight : ndarray of float32, shape (sites,)
        Of a site when light is interpolated between sites.
    clipped_light : float
        From here an edge's bright side may have lost light.
    is_guess : bool
        Whether the light of an overexposed channel was guessed; see `vision.edges.symmetric_plane`.
    """

    channel: int
    table: Table
    weight: Table
    clipped_light: float
    is_guess: bool = False

    @property
    def compiled(self) -> tuple[int, Table, Table]:
        """What `bilinear_light` takes."""
        return self.channel, self.table, self.weight


class Decoder:
    """Turns code values of one camera into light.

    Parameters
    ----------
    response : Response

    Attributes
    ----------
    response : Response
    shown : ndarray of float32, shape (256,)
        Light of every code value of a picture as it is shown.
    """

    def __init__(self, response: Response) -> None:
        self.response: Response = response
        self._table = cache(self._new_table)
        self.shown = self._table_of(Coding("grey"))[0]
        self._curve = light_of(CURVE_CODES, response)
        self._clipped_light = float(self.shown[CLIPPED_CODE])

    def planes(
        self, coding: Coding, outside: Array, inside: Array, brightest: Array | None = None
    ) -> Sequence[LightPlane]:
        """Planes in which an edge can be located, the brightest first; guesses where luma holds a clipped channel.

        Parameters
        ----------
        coding : Coding
        outside, inside : ndarray of float64, shape (channels,)
            Median code values, 0 to 255, of the picture as it is shown, on the background and on the bar.
        brightest : ndarray of float64, shape (channels,), optional
            Code values that only a tenth of the bar exceeds; without them `inside`.
        """
        if coding.samples in {"grey", "colour"}:
            order = np.argsort(-inside)
            table = self._table_of(coding)
            return [LightPlane(int(channel), table, ONE_SITE, self._clipped_light) for channel in order]
        dark, bright = self.shown_light(outside), self.shown_light(inside)
        if coding.samples == "mosaic":
            return self._mosaic_planes(coding, dark, bright, inside)
        clipped = (inside if brightest is None else brightest) >= CLIPPED_CODE
        if not clipped.any() or len(bright) == 1:
            return [self._luma_plane(coding, dark, bright, clipped)]
        guesses = [np.where(clipped, excess * bright, bright) for excess in EXCESSES]
        return [self._luma_plane(coding, dark, guess, clipped) for guess in guesses]

    def whole(self, coding: Coding) -> LightPlane:
        """Plane of grey and luma as if everything were grey, or of a mosaic's sites as they are."""
        return LightPlane(0, self._table_of(coding), ONE_SITE, self._clipped_light)

    def shown_light(self, code: Array) -> Array:
        """Light of code values, 0 to 255, of the picture as it is shown."""
        return light_of(code / 255, self.response)

    def _table_of(self, coding: Coding) -> Table:
        return self._table(coding.bits, coding.black, coding.white)

    def _new_table(self, bits: int, black: int, white: int) -> Table:
        return decoding_table(self.response, bits, black, white)[None]

    def _luma_plane(self, coding: Coding, dark: Array, bright: Array, clipped: NDArray[np.bool_]) -> LightPlane:
        """Luma of the mixtures of background and bar, inverted.

        The light of the brightest channel that is not clipped stands for the share. Two clipped channels leave too
        much open: then all of the edge counts as clipped.
        """
        reference = int(np.argmax(np.where(clipped, -1.0, bright - dark)))
        if not bright[reference] > dark[reference]:
            return self.whole(coding)
        light = np.maximum(dark + SHARES[:, None] * (bright - dark), 0.0)
        red_weight, blue_weight = coding.luma_weights
        weights = np.array([blue_weight, 1 - red_weight - blue_weight, red_weight])
        luma = np.maximum.accumulate(self._encoded(light) @ weights)
        rising = np.concatenate([[True], np.diff(luma) > 1e-9])
        units = np.maximum(np.arange(1 << coding.bits) - coding.black, 0) / (coding.white - coding.black)
        table = np.interp(units, luma[rising], light[rising, reference]).astype(np.float32)
        clipped_light = self._clipped_light if np.count_nonzero(clipped) < 2 else 0.0
        return LightPlane(0, table[None], ONE_SITE, clipped_light, bool(clipped.any()))

    def _encoded(self, light: Array) -> Array:
        return np.interp(light, self._curve, CURVE_CODES)

    def _mosaic_planes(self, coding: Coding, dark: Array, bright: Array, inside: Array) -> list[LightPlane]:
        """The whole mosaic; then without the channels that may be overexposed."""
        usable = inside < CLIPPED_CODE
        planes = [self._mosaic_plane(coding, dark, bright, np.ones(3, dtype=bool))]
        if usable.any() and not usable.all():
            planes.append(self._mosaic_plane(coding, dark, bright, usable))
        return planes

    def _mosaic_plane(self, coding: Coding, dark: Array, bright: Array, used: NDArray[np.bool_]) -> LightPlane:
        step = np.where(used, bright - dark, 0.0)
        reference = int(np.argmax(step))
        if coding.mosaic is None or not step[reference] > 0.0:
            return self.whole(coding)
        weight = np.where(step > LEAST_STEP * step[reference], step**2 / (bright + READ_NOISE), 0.0)
        own = self._table_of(coding)[0]
        tables = [
            dark[reference] + (own - dark[c]) * np.float32(step[reference] / step[c]) if weight[c] > 0 else own
            for c in (BLUE, GREEN, RED)
        ]
        sites = ["BGR".index(colour) for colour in coding.mosaic]
        return LightPlane(
            0,
            np.array([tables[c] for c in sites], np.float32),
            (weight[sites] / weight[reference] + 1e-6).astype(np.float32),
            self._clipped_light,
        )


@njit(nogil=True, cache=True)
def bilinear_light(codes: Codes, plane: tuple[int, Table, Table], x: float, y: float) -> float:
    """Light at a place between pixel centres, from the four around it; in a mosaic from sixteen, four of each site.

    Parameters
    ----------
    codes : ndarray of uint8 or uint16, shape (rows, columns, channels)
    plane : tuple
        Channel, table and weight of a `LightPlane`.
    x, y : float
        Inside the picture.
    """
    channel, table, weight = plane
    j, i = min(int(x), codes.shape[1] - 2), min(int(y), codes.shape[0] - 2)
    u, v = x - j, y - i
    if table.shape[0] == 1:
        upper = (1 - u) * table[0, codes[i, j, channel]] + u * table[0, codes[i, j + 1, channel]]
        lower = (1 - u) * table[0, codes[i + 1, j, channel]] + u * table[0, codes[i + 1, j + 1, channel]]
        return (1 - v) * upper + v * lower
    total, weights = 0.0, 0.0
    for row in range(max(i - 1, 0), min(i + 3, codes.shape[0])):
        for column in range(max(j - 1, 0), min(j + 3, codes.shape[1])):
            site = 2 * (row & 1) + (column & 1)
            share = (2 - abs(x - column)) * (2 - abs(y - row)) * weight[site]
            total += share * table[site, codes[row, column, channel]]
            weights += share
    return total / weights
