"""What the mill wants of a bar: target, tolerances, temperature and grade, from the PLC or from the settings."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Self

from appliance.sizing.set_points import SetPointSettings, grade_of
from plc.registers import REGISTERS

_ROWS = {row.name: row for row in REGISTERS}


@dataclass(frozen=True, slots=True)
class SetPoints:
    """What is wanted; None for what is not set."""

    target_mm: float | None = None
    tolerance_plus_mm: float | None = None
    tolerance_minus_mm: float | None = None
    temperature_c: float | None = None
    grade: int | None = None

    @classmethod
    def from_words(cls, written: Mapping[str, int | bool]) -> Self:
        """Scale the numbers in the words of set points, by register name; 0 or a missing name means "not set"."""
        grade = int(written.get("expansion_grade", 0))
        return cls(
            target_mm=_value(written, "target_diameter"),
            tolerance_plus_mm=_value(written, "tolerance_plus"),
            tolerance_minus_mm=_value(written, "tolerance_minus"),
            temperature_c=_value(written, "steel_temperature"),
            grade=grade or None,
        )

    @classmethod
    def from_settings(cls, wanted: SetPointSettings) -> Self:
        """Set points of the settings file."""
        return cls(
            target_mm=wanted.target_mm,
            tolerance_plus_mm=wanted.tolerance_plus_mm,
            tolerance_minus_mm=wanted.tolerance_minus_mm,
            temperature_c=wanted.temperature_c,
            grade=grade_of(wanted.grade) if wanted.grade else None,
        )

    def over(self, others: Self) -> Self:
        """These set points, each that is not set taken from others."""
        mine = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(others, **{name: value for name, value in mine.items() if value is not None})

    @property
    def tolerance_mm(self) -> tuple[float, float] | None:
        """Allowed deviations above and below the target, mm; None unless both are set."""
        if self.tolerance_plus_mm is None or self.tolerance_minus_mm is None:
            return None
        return self.tolerance_plus_mm, self.tolerance_minus_mm


def _value(written: Mapping[str, int | bool], name: str) -> float | None:
    return _ROWS[name].to_value(int(written.get(name, 0))) or None
