"""When a bar has passed: one rule for its number, its mean and its statistics."""

import math

from vision.readings import SizeReading
from vision.reasons import Reason

GAP_S = 0.3  # chosen: without a bar in view; shorter gaps are missed detections
BLIND_TIME_S = 2.0  # chosen: without any reading


class BarGap:
    """Tells from one reading to the next whether the bar that was there has passed.

    It has after `gap_s` of readings without a bar (`no_bar`), after `BLIND_TIME_S` (at least `gap_s`) without any
    reading, and where time runs back, as in a recording that begins again.

    Parameters
    ----------
    gap_s : float
    """

    def __init__(self, gap_s: float = GAP_S) -> None:
        self._gap_s = gap_s
        self._read_s = self._seen_s = -math.inf  # the last reading; the last one that did not say `no_bar`

    def ends_bar(self, reading: SizeReading, time_s: float) -> bool:
        """Count a reading; whether the bar of those before it has passed.

        Parameters
        ----------
        reading : SizeReading
        time_s : float
            Moment of its exposure.
        """
        runs_back = time_s < self._read_s
        away_s = time_s - self._seen_s
        self._read_s = time_s
        if Reason.NO_BAR in reading.reasons:
            return runs_back or away_s >= self._gap_s
        self._seen_s = time_s
        return runs_back or away_s >= max(BLIND_TIME_S, self._gap_s)
