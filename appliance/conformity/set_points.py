"""Set points of the PLC in their units: target, tolerances, temperature and grade."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from plc.registers import REGISTERS

_ROWS = {row.name: row for row in REGISTERS}


@dataclass(frozen=True, slots=True)
class SetPoints:
    """Set points of the PLC; None for each one that is not set."""

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

    @property
    def tolerance_mm(self) -> tuple[float, float] | None:
        """Allowed deviations above and below the target, mm; None unless both are set."""
        if self.tolerance_plus_mm is None or self.tolerance_minus_mm is None:
            return None
        return self.tolerance_plus_mm, self.tolerance_minus_mm


def _value(written: Mapping[str, int | bool], name: str) -> float | None:
    return _ROWS[name].to_value(int(written.get(name, 0))) or None
