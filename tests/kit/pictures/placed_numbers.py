"""Random numbers at a told place of their range, so that its ends are seen at once and not after thousands of draws."""

from collections.abc import Sequence
from typing import Any

import numpy as np


class PlacedNumbers(np.random.Generator):
    """A generator whose ranges are seen at their ends; noise (`standard_normal` and fields of `random`) stays random.

    Parameters
    ----------
    share : float or None
        Where in its range each number lies: 0 the least, 1 the largest; of choices and counts the first and the last.
        None: at random.
    chance : float
        What `random()` gives: at 0 all happens that has a chance, at 1 nothing.
    deviation : float
        How many standard deviations a normal number lies off its mean.
    whole : float or None
        The share for counts and choices, where it is another one.
    """

    def __init__(
        self, share: float | None, chance: float = 0.0, deviation: float = 0.0, *, whole: float | None = None
    ) -> None:
        super().__init__(np.random.PCG64(1))
        self._share, self._chance, self._deviation = share, chance, deviation
        self._whole = (share or 0.0) if whole is None else whole

    def random(self, size: Any = None, dtype: Any = np.float64, out: Any = None) -> Any:
        return self._chance if size is None and out is None else super().random(size, dtype, out)

    def uniform(self, low: Any = 0.0, high: Any = 1.0, size: Any = None) -> Any:
        if self._share is None:
            return super().uniform(low, high, size)
        return self._filled(np.asarray(low) + self._share * (np.asarray(high) - np.asarray(low)), size)

    def normal(self, loc: Any = 0.0, scale: Any = 1.0, size: Any = None) -> Any:
        return self._filled(np.asarray(loc) + self._deviation * np.asarray(scale), size)

    def integers(self, low: int, high: int | None = None, size: Any = None, **_: Any) -> Any:
        first, end = (0, low) if high is None else (low, high)
        return self._filled(np.asarray(first + round(self._whole * (end - 1 - first))), size)

    def choice(self, a: Sequence[Any], size: Any = None, **_: Any) -> Any:
        return self._filled(np.asarray(a)[round(self._whole * (len(a) - 1))], size)

    @staticmethod
    def _filled(value: Any, size: Any) -> Any:
        return value[()] if size is None else np.full(size, value)
