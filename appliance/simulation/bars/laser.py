"""The mill's laser: the range along a beam to whatever lies there, with the noise of a sensor."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars.bars import Bar

Point = NDArray[np.float64]

# Of the embedded line: over its middle, looking down.
MILL_ORIGIN_MM, MILL_DIRECTION = np.array([0.0, 0.0, 2200.0]), np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True, slots=True, eq=False)
class Laser:
    """A one-point laser in the true world frame.

    Attributes
    ----------
    origin_mm, direction : ndarray of float64, shape (3,)
        Where the range is 0, and the beam's unit vector; it points down.
    noise_mm : float
        Standard deviation of a range: hot surface, speckle, electronics.
    """

    origin_mm: Point
    direction: Point
    noise_mm: float = 0.3

    def true_range_mm(self, bar: Bar | None) -> float:
        """Range to the bar, or to the plane of the rollers beside it.

        Parameters
        ----------
        bar : Bar or None
        """
        ground_mm = -self.origin_mm[2] / self.direction[2]
        range_mm = math.nan if bar is None else self._to_bar_mm(bar)
        return float(ground_mm if math.isnan(range_mm) else range_mm)

    def range_mm(self, bar: Bar | None, rng: np.random.Generator) -> float:
        """The same with noise.

        Parameters
        ----------
        bar : Bar or None
        rng : numpy.random.Generator
        """
        return self.true_range_mm(bar) + float(rng.normal(0, self.noise_mm))

    def _to_bar_mm(self, bar: Bar) -> float:
        """Range to the side of the bar, an ellipse in its section; NaN beside it and beyond its ends.

        Camber moves the section sideways by less than 0.3 mm where the beam meets the bar, and is left out.
        """
        turn, across, up = math.radians(bar.ovality_deg), bar.across, np.array([0.0, 0.0, 1.0])
        axes = np.array([across * math.cos(turn) + up * math.sin(turn), up * math.cos(turn) - across * math.sin(turn)])
        half_mm = np.array([bar.diameter_mm + bar.ovality_mm / 2, bar.diameter_mm - bar.ovality_mm / 2]) / 2
        start = (axes @ (self.origin_mm - bar.axis_point_mm)) / half_mm
        beam = (axes @ self.direction) / half_mm
        a, b, c = float(beam @ beam), 2 * float(start @ beam), float(start @ start) - 1
        if b * b < 4 * a * c:
            return math.nan
        range_mm = (-b - math.sqrt(b * b - 4 * a * c)) / (2 * a)
        spot_mm = self.origin_mm + range_mm * self.direction
        station_mm = float((spot_mm - bar.axis_point_mm) @ bar.axis_direction)
        return range_mm if bar.tail_mm <= station_mm <= bar.head_mm else math.nan
