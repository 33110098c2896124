"""What a diameter means against the set points: cold size, trust, decision, correction. Pure arithmetic."""

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol, Self

from appliance.expansion import GRADES
from appliance.settings import CorrectionSettings
from plc.registers import REGISTERS

U_MAX_WITHOUT_TOLERANCE_MM = 0.25
SHARE_OF_TOLERANCE = 8  # U_max is this part of the tolerance's width

_ROWS = {row.name: row for row in REGISTERS}


class Decision(enum.IntEnum):
    """Outcome against the tolerance, as in the register `decision`."""

    NONE = 0
    IN = 1
    OUT = 2
    UNDECIDED = 3


class Size(NamedTuple):
    """A diameter and its expanded uncertainty (k = 2), mm."""

    diameter_mm: float
    expanded_mm: float


@dataclass(frozen=True, slots=True)
class SetPoints:
    """What the PLC wants; None for what it has not set."""

    target_mm: float | None = None
    tolerance_plus_mm: float | None = None
    tolerance_minus_mm: float | None = None
    temperature_c: float | None = None
    grade: int | None = None

    @classmethod
    def of(cls, written: Mapping[str, int | bool]) -> Self:
        """Set points from the numbers in their words, by register; 0 and missing mean "not set"."""
        grade = int(written.get("expansion_grade", 0))
        return cls(
            target_mm=_value(written, "target_diameter"),
            tolerance_plus_mm=_value(written, "tolerance_plus"),
            tolerance_minus_mm=_value(written, "tolerance_minus"),
            temperature_c=_value(written, "steel_temperature"),
            grade=grade or None,
        )

    @property
    def tolerance_mm(self) -> tuple[float, float] | None:
        """Allowed above and below the target; None unless both are set."""
        if self.tolerance_plus_mm is None or self.tolerance_minus_mm is None:
            return None
        return self.tolerance_plus_mm, self.tolerance_minus_mm


def _value(written: Mapping[str, int | bool], name: str) -> float | None:
    return _ROWS[name].to_value(int(written.get(name, 0))) or None


def cold_size(hot: Size, points: SetPoints, temperature_u_c: float) -> Size | None:
    """Size at 20 °C: cold = hot / (1 + e), e the elongation at the section's mean temperature.

    Parameters
    ----------
    hot : Size
    points : SetPoints
    temperature_u_c : float
        Standard uncertainty (k = 1) of the temperature. Its part is half the change of the cold size from one u
        below to one u above (GUM 5.1.3, note 2), which also holds across the bends of the curve.

    Returns
    -------
    Size or None
        None without a temperature, without a grade, or with a grade that is not in the table.
    """
    if points.grade not in GRADES or points.temperature_c is None:
        return None
    elongation = GRADES[points.grade].elongation
    factor, cooler, hotter = (
        1 / (1 + elongation(points.temperature_c + change)) for change in (0, -temperature_u_c, temperature_u_c)
    )
    u_temperature_mm = hot.diameter_mm * (cooler - hotter) / 2
    return Size(hot.diameter_mm * factor, math.hypot(hot.expanded_mm * factor, 2 * u_temperature_mm))


def to_judge(hot: Size, cold: Size | None, points: SetPoints) -> Size | None:
    """The size that target and tolerances are meant for: cold if a grade is set, else hot."""
    return hot if points.grade is None else cold


def allowed_uncertainty_mm(points: SetPoints) -> float:
    """U_max, the expanded uncertainty that costs no trust."""
    tolerance = points.tolerance_mm
    return U_MAX_WITHOUT_TOLERANCE_MM if tolerance is None else sum(tolerance) / SHARE_OF_TOLERANCE


class Judged(Protocol):
    """What the trust in a reading follows from; a reading and its message both have it."""

    @property
    def valid(self) -> bool:
        """Whether there is a value."""
        ...

    @property
    def windows_kept(self) -> int:
        """Windows that agree with it."""
        ...

    @property
    def windows_total(self) -> int:
        """All windows."""
        ...

    @property
    def expanded_uncertainty_mm(self) -> float | None:
        """U, mm."""
        ...

    @property
    def trust_limit(self) -> float:
        """Most that the trust may be, percent."""
        ...


def trust_percent(reading: Judged, allowed_mm: float = U_MAX_WITHOUT_TOLERANCE_MM) -> float:
    """Trust in a reading: 100 x kept / total x min(1, U_max / U), at most its limit; 0 without a value.

    Parameters
    ----------
    reading : SizeReading or ReadingMessage
    allowed_mm : float
        U_max.
    """
    expanded_mm = reading.expanded_uncertainty_mm
    if not reading.valid or not reading.windows_total or not expanded_mm:
        return 0.0
    trust = 100 * reading.windows_kept / reading.windows_total * min(1.0, allowed_mm / expanded_mm)
    return min(trust, reading.trust_limit)


def decide(deviation_mm: float, expanded_mm: float, tolerance_mm: tuple[float, float]) -> Decision:
    """Whether a size is in tolerance, with the guard band g = U on both sides of both limits.

    Parameters
    ----------
    deviation_mm : float
        Size minus target.
    expanded_mm : float
        U of the size.
    tolerance_mm : tuple of float
        Allowed above and below the target, both positive.
    """
    plus_mm, minus_mm = tolerance_mm
    inside_mm = min(plus_mm - deviation_mm, deviation_mm + minus_mm)
    if inside_mm >= expanded_mm:
        return Decision.IN
    return Decision.OUT if -inside_mm >= expanded_mm else Decision.UNDECIDED


def wanted_correction_mm(deviation_mm: float, settings: CorrectionSettings) -> float:
    """Change of the stand's gap that would answer a deviation: -gain x deviation, clamped, 0 in the dead band."""
    if abs(deviation_mm) <= settings.dead_band_mm:
        return 0.0
    wanted_mm = -settings.gain * deviation_mm
    return max(-settings.limit_mm, min(settings.limit_mm, wanted_mm))


def towards(wanted_mm: float, before_mm: float, most_mm: float) -> float:
    """`wanted_mm`, or as near to it as a change of at most `most_mm` leads."""
    return max(before_mm - most_mm, min(before_mm + most_mm, wanted_mm))
