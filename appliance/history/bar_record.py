"""What is kept of one bar, from all of its valid readings."""

import math
from collections.abc import Mapping

from appliance.conformity.bar_statistics import Part, part_of_bar
from appliance.conformity.cold_size import Size, judged_size
from appliance.conformity.decision import decide
from appliance.conformity.set_points import SetPoints
from appliance.history.tables import Value
from appliance.sizing.message import ReadingMessage
from plc.codes import Decision
from plc.rows import Value as Served
from vision.reasons import Reason


class Mean:
    """Mean, smallest, largest and standard deviation of numbers that come one by one (Welford 1962)."""

    def __init__(self) -> None:
        self.count = 0
        self.mean = self.smallest = self.largest = math.nan
        self._squares = 0.0

    def add(self, number: float) -> None:
        """Count one more number; NaN makes the mean NaN."""
        self.count += 1
        before = 0.0 if self.count == 1 else self.mean
        self.mean = before + (number - before) / self.count
        self._squares += (number - before) * (number - self.mean)
        self.smallest = number if self.count == 1 else min(self.smallest, number)
        self.largest = number if self.count == 1 else max(self.largest, number)

    @property
    def deviation(self) -> float:
        """Standard deviation with n - 1; NaN for fewer than two numbers."""
        return math.sqrt(self._squares / (self.count - 1)) if self.count > 1 else math.nan


class _Sizes:
    """Sizes of one part of a bar, hot and cold, with their uncertainties."""

    def __init__(self) -> None:
        self.hot, self.hot_expanded, self.cold, self.cold_expanded = Mean(), Mean(), Mean(), Mean()

    def add(self, served: Mapping[str, Served]) -> None:
        self.hot.add(_number(served, "diameter"))
        self.hot_expanded.add(_number(served, "expanded_uncertainty"))
        self.cold.add(_number(served, "diameter_cold"))
        self.cold_expanded.add(_number(served, "expanded_uncertainty_cold"))


class BarRecord:
    """One bar, reading by reading.

    Parameters
    ----------
    bar : int
        Its number, as `bar_sequence`.
    """

    def __init__(self, bar: int) -> None:
        self.bar = bar
        self._all = _Sizes()
        self._parts = {part: _Sizes() for part in (Part.HEAD, Part.BODY, Part.TAIL)}
        self._started_utc_ms = self._ended_utc_ms = 0
        self._trust = Mean()
        self._out = 0
        self._reasons = Reason.NONE
        self._simulated = False

    def add(self, message: ReadingMessage, served: Mapping[str, Served]) -> None:
        """Count a valid reading.

        Parameters
        ----------
        message : ReadingMessage
        served : mapping of str to value
            Its values in the registers, by name.
        """
        self._started_utc_ms = self._started_utc_ms or message.exposed_utc_ms
        self._ended_utc_ms = message.exposed_utc_ms
        self._all.add(served)
        self._trust.add(_number(served, "trust"))
        part = part_of_bar(message.reading.reasons)
        if part in self._parts:
            self._parts[part].add(served)
        self._out += int(served.get("decision") or 0) == int(Decision.OUT)
        self._reasons |= message.reading.reasons
        self._simulated = message.simulated

    def values(self, points: SetPoints, product_id: int, trust_min: float) -> dict[str, Value]:
        """Row of the table of bars, without its run.

        Parameters
        ----------
        points : SetPoints
            When the bar has passed: they decide.
        product_id : int
        trust_min : float
            Mean trust of the readings below which the bar is undecided.
        """
        body = self._parts[Part.BODY]
        sizes = body if body.hot.count else self._all
        return {
            "started_utc_ms": self._started_utc_ms,
            "bar": self.bar,
            "ended_utc_ms": self._ended_utc_ms,
            "product_id": product_id,
            "grade": points.grade,
            "temperature_c": points.temperature_c,
            "target_mm": points.target_mm,
            "tolerance_plus_mm": points.tolerance_plus_mm,
            "tolerance_minus_mm": points.tolerance_minus_mm,
            "readings": self._all.hot.count,
            "readings_out": self._out,
            "head_mm": self._parts[Part.HEAD].hot.mean,
            "body_mm": body.hot.mean,
            "tail_mm": self._parts[Part.TAIL].hot.mean,
            "smallest_mm": sizes.hot.smallest,
            "mean_mm": sizes.hot.mean,
            "largest_mm": sizes.hot.largest,
            "spread_mm": sizes.hot.deviation,
            "expanded_uncertainty_mm": sizes.hot_expanded.mean,
            "mean_cold_mm": sizes.cold.mean,
            "expanded_uncertainty_cold_mm": sizes.cold_expanded.mean,
            "trust": self._trust.mean,
            "reasons": int(self._reasons),
            "simulated": self._simulated,
            **_judged(sizes, points, trusted=self._trust.mean >= trust_min),
        }


def _judged(sizes: _Sizes, points: SetPoints, *, trusted: bool) -> dict[str, Value]:
    hot = Size(sizes.hot.mean, sizes.hot_expanded.mean)
    cold = None if math.isnan(sizes.cold.mean) else Size(sizes.cold.mean, sizes.cold_expanded.mean)
    judged = judged_size(hot, cold, points)
    if judged is None or points.target_mm is None:
        return {"deviation_mm": None, "decision": int(Decision.NONE)}
    deviation_mm = judged.diameter_mm - points.target_mm
    decision = Decision.NONE
    if points.tolerance_mm is not None:
        decision = Decision.UNDECIDED
        if trusted:
            decision = decide(deviation_mm, judged.expanded_mm, points.tolerance_mm)
    return {"deviation_mm": deviation_mm, "decision": int(decision)}


def _number(served: Mapping[str, Served], name: str) -> float:
    value = served.get(name)
    return math.nan if value is None else float(value)
