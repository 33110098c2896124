"""What the standing reading means for the mill, in registers: judged against what the PLC wants."""

import math
from collections.abc import Mapping

from appliance.conformity.cold_size import Size, cold_size, to_judge
from appliance.conformity.correction import towards, wanted_correction_mm
from appliance.conformity.decision import Decision, allowed_uncertainty_mm, decide
from appliance.conformity.set_points import SetPoints
from appliance.conformity.settings import CorrectionSettings, JudgingSettings
from appliance.sizing.message import ReadingMessage
from appliance.sizing.trust import trust_percent
from plc.rows import Value


class Advisor:
    """Judges readings; remembers only the last correction, whose change is limited.

    Parameters
    ----------
    judging : JudgingSettings
    correction : CorrectionSettings

    Attributes
    ----------
    points : SetPoints
        What the PLC wants now.
    """

    def __init__(self, judging: JudgingSettings, correction: CorrectionSettings) -> None:
        self.points = SetPoints()
        self._judging = judging
        self._correction = correction
        self._corrected_mm = 0.0
        self._corrected_s = math.inf  # no time has passed at the first moment

    def values(self, reading: ReadingMessage | None, now_s: float) -> dict[str, Value]:
        """Values of the registers, by name.

        Parameters
        ----------
        reading : ReadingMessage or None
            The one that may be served now.
        now_s : float
            Monotonic time.
        """
        hot = _size(reading)
        if reading is None or hot is None:
            correction_mm = self._advise(None, now_s)
            return {"correction": correction_mm} | ({} if reading is None else {"trust": 0.0})
        trust = trust_percent(reading, allowed_uncertainty_mm(self.points))
        judged = self._judge(hot)
        trusted = trust >= self._judging.trust_min
        deviation_mm = judged.get("deviation") if trusted else None
        return judged | {"trust": trust, "correction": self._advise(deviation_mm, now_s)}

    def low_trust(self, values: Mapping[str, Value]) -> bool:
        """Whether a bar is there whose diameter cannot be trusted."""
        trust = values.get("trust")
        return bool(values.get("bar_present")) and trust is not None and trust < self._judging.trust_min

    def _judge(self, hot: Size) -> dict[str, Value]:
        points = self.points
        cold = cold_size(hot, points, self._judging.temperature_u_c)
        values: dict[str, Value] = {}
        if cold is not None:
            values = {"diameter_cold": cold.diameter_mm, "expanded_uncertainty_cold": cold.expanded_mm}
        judged = to_judge(hot, cold, points)
        if judged is None or points.target_mm is None:
            return values
        deviation_mm = judged.diameter_mm - points.target_mm
        tolerance_mm = points.tolerance_mm
        decision = Decision.NONE if tolerance_mm is None else decide(deviation_mm, judged.expanded_mm, tolerance_mm)
        return values | {"deviation": deviation_mm, "decision": decision}

    def _advise(self, deviation_mm: Value, now_s: float) -> float | None:
        """Correction for a trusted deviation, at once 0 without one; no value as long as there is no target."""
        elapsed_s, self._corrected_s = max(0.0, now_s - self._corrected_s), now_s
        if deviation_mm is None:
            self._corrected_mm = 0.0
        else:
            wanted_mm = wanted_correction_mm(deviation_mm, self._correction)
            most_mm = self._correction.rate_mm_per_s * elapsed_s
            self._corrected_mm = towards(wanted_mm, self._corrected_mm, most_mm)
        return None if self.points.target_mm is None else self._corrected_mm


def _size(reading: ReadingMessage | None) -> Size | None:
    if reading is None or not reading.valid or reading.diameter_mm is None or reading.expanded_uncertainty_mm is None:
        return None
    return Size(reading.diameter_mm, reading.expanded_uncertainty_mm)
