"""Expanded uncertainty of the mean diameter of a bar, from all of its readings, one by one."""

import math

from vision.readings import SizeReading
from vision.sizing.correlated_mean import LEAST_COUNT_SCATTER, mean_variance_factor, own_uncertainty_mm


class MeanUncertainty:
    """U of the plain mean of readings.

    Readings share calibration, board, light, the section's unseen part and limbs that lie off: those parts stay whole,
    as mean squares. The others shrink as the readings' scatter and the correlation of neighbours allow: the variance
    of the mean is s^2 / n x `mean_variance_factor`, and at least that of the stated parts.
    """

    def __init__(self) -> None:
        self._count = 0
        self._first_mm = self._last_mm = math.nan
        self._sum = self._squares = self._products = 0.0  # of diameters less the first one
        self._shared_mm2 = self._own_mm2 = 0.0

    def add(self, reading: SizeReading) -> None:
        """Count a valid reading."""
        if not self._count:
            self._first_mm = reading.diameter_mm
        away_mm = reading.diameter_mm - self._first_mm
        if self._count:
            self._products += away_mm * (self._last_mm - self._first_mm)
        self._last_mm = reading.diameter_mm
        self._count += 1
        self._sum += away_mm
        self._squares += away_mm**2
        own_mm = own_uncertainty_mm(reading)
        self._own_mm2 += own_mm**2
        self._shared_mm2 += max((reading.expanded_uncertainty_mm / 2) ** 2 - own_mm**2, 0.0)

    @property
    def expanded_mm(self) -> float:
        """U = 2 u of the mean, mm; NaN without readings."""
        if not self._count:
            return math.nan
        own_mm2 = self._own_mm2 / self._count**2
        return 2 * math.sqrt(self._shared_mm2 / self._count + max(own_mm2, self._scatter_mm2()))

    def _scatter_mm2(self) -> float:
        """Variance of the mean from the readings' scatter and the correlation of neighbours."""
        count = self._count
        if count < LEAST_COUNT_SCATTER:
            return 0.0
        mean = self._sum / count
        squares = max(self._squares - count * mean**2, 0.0)
        # sum of (x_i - m)(x_i-1 - m): the first one (0) and the last one have one neighbour each
        both_ends = self._last_mm - self._first_mm
        neighbours = self._products - mean * (2 * self._sum - both_ends) + (count - 1) * mean**2
        r = neighbours / squares if squares > 0 else 0.0
        return squares / (count - 1) / count * mean_variance_factor(r, count)
