"""Judges the published reading against the PLC's set points: cold size, trust, decision, correction."""

import math

from appliance.conformity.cold_size import Size, cold_size, judged_size
from appliance.conformity.correction import rate_limited_mm, wanted_correction_mm
from appliance.conformity.decision import allowed_uncertainty_mm, decide
from appliance.conformity.set_points import SetPoints
from appliance.conformity.settings import CorrectionSettings, JudgingSettings
from appliance.sizing.trust import trust_percent
from plc.codes import Decision
from plc.rows import Value
from vision.readings import SizeReading
from vision.reasons import Reason


class Advisor:
    """Judges readings; keeps only the last correction, whose rate of change is limited.

    Parameters
    ----------
    judging : JudgingSettings
    correction : CorrectionSettings

    Attributes
    ----------
    decision : Decision
        At the last `update`; `NONE` without a value, a target or a tolerance.
    low_trust : bool
        Whether, at the last `update`, a bar was measured with a trust below `trust_min`.
    """

    def __init__(self, judging: JudgingSettings, correction: CorrectionSettings) -> None:
        self.decision = Decision.NONE
        self.low_trust = False
        self._judging = judging
        self._correction = correction
        self._corrected_mm = 0.0
        self._corrected_s = math.inf  # the first update changes no correction
        self._values: dict[str, Value] = {}

    def update(self, reading: SizeReading | None, points: SetPoints, now_s: float) -> None:
        """Judge the reading that may be served, and change the correction by at most its rate.

        Parameters
        ----------
        reading : SizeReading or None
            Reading that may be served; None withdraws all values.
        points : SetPoints
            Set points in force.
        now_s : float
            Monotonic time.
        """
        trust = 0.0 if reading is None else trust_percent(reading, allowed_uncertainty_mm(points))
        trusted = trust >= self._judging.trust_min
        self.low_trust = reading is not None and Reason.NO_BAR not in reading.reasons and not trusted
        self.decision = Decision.NONE
        judged = self._judge(reading, points) if reading is not None and reading.valid else {}
        if self.decision is not Decision.NONE and not trusted:
            self.decision = Decision.UNDECIDED
        self._move_correction(judged.get("deviation") if trusted else None, now_s)
        self._values = judged if reading is None else judged | {"trust": trust, "decision": self.decision}
        self._values["correction"] = None if points.target_mm is None else self._corrected_mm

    def values(self) -> dict[str, Value]:
        """Values of the registers at the last `update`, by name."""
        return self._values

    def _judge(self, reading: SizeReading, points: SetPoints) -> dict[str, Value]:
        hot = Size(reading.diameter_mm, reading.expanded_uncertainty_mm)
        cold = cold_size(hot, points, self._judging.temperature_u_c)
        values: dict[str, Value] = {}
        if cold is not None:
            values = {"diameter_cold": cold.diameter_mm, "expanded_uncertainty_cold": cold.expanded_mm}
        judged = judged_size(hot, cold, points)
        if judged is None or points.target_mm is None:
            return values
        deviation_mm = judged.diameter_mm - points.target_mm
        if points.tolerance_mm is not None:
            self.decision = decide(deviation_mm, judged.expanded_mm, points.tolerance_mm)
        return values | {"deviation": deviation_mm}

    def _move_correction(self, deviation_mm: Value, now_s: float) -> None:
        """Change the correction towards that of a trusted deviation; without one set it to 0 at once."""
        elapsed_s, self._corrected_s = max(0.0, now_s - self._corrected_s), now_s
        if deviation_mm is None:
            self._corrected_mm = 0.0
            return
        wanted_mm = wanted_correction_mm(deviation_mm, self._correction)
        self._corrected_mm = rate_limited_mm(wanted_mm, self._corrected_mm, self._correction.rate_mm_per_s * elapsed_s)
