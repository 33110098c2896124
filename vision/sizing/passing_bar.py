"""The passing bar's own values from the readings of its frames: diameter, uncertainty, ovality.

The diameter is the weighted mean of the last frames, at most `MEMORY_FRAMES`, so its value has no latency. What frames
do not share (scatter of the edges, hot air, motion) averages out as their correlation allows; what they share
(calibration, board, light, limbs that lie off, the section's unseen part) does not. A step in diameter, which two
frames in a row must show, begins a new mean.
"""

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.readings import SizeReading
from vision.sizing.bar_gap import BarGap
from vision.sizing.correlated_mean import LEAST_COUNT_SCATTER, mean_variance_factor, own_uncertainty_mm, stated
from vision.sizing.section_turn import turning_section

Array = NDArray[np.float64]

MEMORY_FRAMES = 50  # chosen: 2 s at 25 frames a second
STEP_SIGMAS = 4.0  # chosen: a frame further from the mean than 4 standard deviations of both belongs to another size
LEAST_STEP_MM = 0.3  # chosen: a smaller difference is no step; places in the pictures differ by up to 0.2 mm
LEAST_OWN_MM = 0.01  # chosen: least standard uncertainty of a frame of its own, so that none takes all the weight


@dataclass(frozen=True, slots=True)
class _Frame:
    """What a reading brings to the bar's values."""

    time_s: float
    reading: SizeReading

    @property
    def own_mm(self) -> float:
        """Standard uncertainty that it does not share with other frames."""
        return math.hypot(own_uncertainty_mm(self.reading), LEAST_OWN_MM)


class PassingBar:
    """The bar in the measuring region, from frame to frame; starts anew with each bar and each step in diameter."""

    def __init__(self) -> None:
        self._gap = BarGap()
        self._frames: deque[_Frame] = deque(maxlen=MEMORY_FRAMES)
        self._apart: _Frame | None = None  # the last frame, if it lies apart from the mean

    def add(self, reading: SizeReading, time_s: float) -> SizeReading:
        """Count a frame.

        Parameters
        ----------
        reading : SizeReading
        time_s : float
            Moment of exposure.

        Returns
        -------
        SizeReading
            The reading with the bar's values; NaN where the reading itself has no value.
        """
        if self._gap.ends_bar(reading, time_s):
            self._frames.clear()
            self._apart = None
        if not reading.valid:
            return reading
        self._count(_Frame(time_s, reading))
        return self._with_bar(reading)

    def _count(self, frame: _Frame) -> None:
        if not self._frames or self._fits(frame):
            self._apart = None
            self._frames.append(frame)
        elif self._apart is None:
            self._apart = frame
        else:
            before, self._apart = self._apart, None
            self._frames.clear()
            self._frames.extend([before, frame] if _near(before, frame) else [frame])

    def _fits(self, frame: _Frame) -> bool:
        mean_mm, u_mm = self._mean()
        apart_mm = abs(frame.reading.diameter_mm - mean_mm)
        return apart_mm <= max(LEAST_STEP_MM, STEP_SIGMAS * math.hypot(u_mm, max(frame.own_mm, self._scatter_mm())))

    def _diameters(self) -> tuple[Array, Array]:
        diameter_mm = np.array([frame.reading.diameter_mm for frame in self._frames])
        return diameter_mm, np.array([frame.own_mm for frame in self._frames])

    def _scatter_mm(self) -> float:
        if len(self._frames) < LEAST_COUNT_SCATTER:
            return 0.0
        return float(self._diameters()[0].std(ddof=1))

    def _stated_mm(self) -> float:
        """Standard uncertainty of the mean by what the frames state of themselves."""
        return float(1 / np.sqrt(np.sum(self._diameters()[1] ** -2)))

    def _mean(self) -> tuple[float, float]:
        """Weighted mean and its standard uncertainty from what frames do not share."""
        diameter_mm, own_mm = self._diameters()
        weight = own_mm**-2 / np.sum(own_mm**-2)
        mean_mm, stated_mm = float(weight @ diameter_mm), self._stated_mm()
        if len(diameter_mm) < LEAST_COUNT_SCATTER:
            return mean_mm, stated_mm
        away = diameter_mm - mean_mm
        neighbours = float(away[1:] @ away[:-1] / max(away @ away, 1e-12))
        seen_mm = float(np.sqrt(weight**2 @ away**2 * mean_variance_factor(neighbours, len(away))))
        return mean_mm, max(stated_mm, seen_mm)

    def _with_bar(self, reading: SizeReading) -> SizeReading:
        mean_mm, u_mm = self._mean()
        newest = self._frames[-1]
        shared_mm2 = (newest.reading.expanded_uncertainty_mm / 2) ** 2 - newest.own_mm**2
        section = turning_section(
            np.array([frame.time_s for frame in self._frames]),
            np.array([[frame.reading.width_left_mm, frame.reading.width_right_mm] for frame in self._frames]),
            float(np.median(self._diameters()[1])),
        )
        if section is not None:  # over half a turn all widths were seen
            mean_mm, u_mm = section.diameter_mm, max(self._stated_mm(), section.u_diameter_mm)
            shared_mm2 -= stated(newest.reading.u_shape_mm) ** 2
        return replace(
            reading,
            bar_frames=len(self._frames),
            bar_diameter_mm=mean_mm,
            bar_expanded_uncertainty_mm=2 * math.sqrt(u_mm**2 + max(shared_mm2, 0.0)),
            bar_ovality_mm=section.ovality_mm if section else math.nan,
            bar_ovality_expanded_uncertainty_mm=2 * section.u_ovality_mm if section else math.nan,
        )


def _near(first: _Frame, second: _Frame) -> bool:
    apart_mm = abs(first.reading.diameter_mm - second.reading.diameter_mm)
    return apart_mm <= max(LEAST_STEP_MM, STEP_SIGMAS * math.hypot(first.own_mm, second.own_mm))
