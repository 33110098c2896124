"""Reports edges of the bar that are overexposed or too dark, and adjusts the exposure of cameras that allow it.

An overexposed edge moves outwards, by 0.4 to 0.7 mm when red is clipped four times over (docs/guides/cameras.md); a
dark edge is noisy. Exposure changes by one step after `after_s` of trouble, so that neither a single bar nor a gap
between bars changes it.
"""

import math
from typing import NamedTuple

from appliance.cameras.settings import ExposureSettings
from appliance.diagnostics.persistence import Persistence

TROUBLES = ("exposure_high", "exposure_low")
DARKER_FACTOR, BRIGHTER_FACTOR = 0.8, 1.25  # chosen: one step of exposure time, up and down by the same ratio


class Advice(NamedTuple):
    """New exposure time, or the faults of the present one.

    Attributes
    ----------
    exposure_us : float
        Exposure time to set now, µs; NaN: leave it.
    faults : dict of str to str
        Active faults by name, each with its detail.
    """

    exposure_us: float
    faults: dict[str, str]


NO_ADVICE = Advice(math.nan, {})


class ExposureGuard:
    """Judges the light along the bar's edges over time.

    Parameters
    ----------
    settings : ExposureSettings
    adjustable : bool
        Whether the exposure time can be set while the cameras run.
    """

    def __init__(self, settings: ExposureSettings, *, adjustable: bool) -> None:
        self._settings = settings
        self._control = settings.control and adjustable
        self._persistence = {trouble: Persistence(settings.after_s) for trouble in TROUBLES}

    def advise(self, clipped_share: float, light: float, exposure_us: float, now_s: float) -> Advice:
        """Judge the edges of one bar.

        Parameters
        ----------
        clipped_share : float
            Largest share of a limb's points that is overexposed; NaN without a bar, which changes nothing.
        light : float
            Light of the bar beside its darkest limb, as a share of full scale; NaN without a bar.
        exposure_us : float
            Exposure time of these pictures; NaN if it is unknown, and then it is not set.
        now_s : float
            Monotonic time.
        """
        if math.isnan(clipped_share):
            return NO_ADVICE
        trouble = self._trouble_of(clipped_share, light)
        for name, persistence in self._persistence.items():
            persistence.add(now_s, there=name == trouble)
        if not trouble or not self._persistence[trouble].lasts:
            return NO_ADVICE
        step = DARKER_FACTOR if trouble == "exposure_high" else BRIGHTER_FACTOR
        wanted_us = min(max(exposure_us * step, self._settings.shortest_us), self._settings.longest_us)
        # an exposure outside the bounds may not be stepped the wrong way to reach them; false for NaN: unknown
        if self._control and (wanted_us - exposure_us) * (step - 1) > 0 and abs(wanted_us - exposure_us) >= 1:
            self._persistence[trouble].reset()  # the next step waits for after_s again
            return Advice(wanted_us, {})
        return Advice(math.nan, {trouble: self._sentence(clipped_share, light, exposure_us, step)})

    def _trouble_of(self, clipped_share: float, light: float) -> str:
        if 100 * clipped_share > self._settings.clipped_max_percent:
            return "exposure_high"
        return "exposure_low" if light < self._settings.light_min else ""

    @staticmethod
    def _sentence(clipped_share: float, light: float, exposure_us: float, step: float) -> str:
        seen = (
            f"{100 * clipped_share:.0f} % of an edge is overexposed"
            if step < 1
            else f"{100 * light:.0f} % of full light"
        )
        if math.isnan(exposure_us):
            return f"{seen}; expose for {step:g} times as long"
        return f"{seen}; expose for about {exposure_us * step:.0f} µs instead of {exposure_us:.0f}"
