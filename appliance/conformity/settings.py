"""Settings of what is wanted of a bar, of the judgement of its diameter and of the advised correction."""

import difflib
from typing import Annotated

from pydantic import AfterValidator, Field

from appliance.conformity.set_points import SetPoints
from appliance.conformity.steels import STEELS, grade_of
from appliance.settings.section import Section, refusal, unit


class JudgingSettings(Section):
    """How a diameter is judged."""

    trust_min: float = Field(
        default=50.0,
        ge=0,
        le=100,
        description="Trust below which alarm_low_trust comes and correction is 0",
        json_schema_extra=unit("%"),
    )
    temperature_u_c: float = Field(
        default=25.0,
        ge=0,
        le=200,
        description="Standard uncertainty of steel_temperature as the section's mean",
        json_schema_extra=unit("°C"),
    )
    bar_gap_ms: int = Field(
        default=300,
        ge=0,
        le=60000,
        description="Time without a bar that parts two bars",
        json_schema_extra=unit("ms"),
    )


def _steel(name: str) -> str:
    if name and grade_of(name) is None:
        near = difflib.get_close_matches(name, STEELS, n=1)
        advice = f"did you mean {near[0]}?" if near else "give a name of the table of grades, as 42CrMo4 or 1.4301"
        raise refusal(f"{name!r} is no steel that is known; {advice}")
    return name


class SetPointSettings(Section):
    """What is wanted of a bar as long as the PLC has not written it; the sizes are cold if a grade is in force."""

    target_mm: float | None = Field(
        default=None, ge=10, le=655.34, description="Wanted diameter", json_schema_extra=unit("mm")
    )
    tolerance_plus_mm: float | None = Field(
        default=None, ge=0.01, le=50, description="Allowed above the target", json_schema_extra=unit("mm")
    )
    tolerance_minus_mm: float | None = Field(
        default=None, ge=0.01, le=50, description="Allowed below the target", json_schema_extra=unit("mm")
    )
    grade: Annotated[str, AfterValidator(_steel)] = Field(
        default="", description="Steel by its name or number, as in the table of grades; empty: not set"
    )
    temperature_c: float | None = Field(
        default=None,
        ge=100,
        le=1400,
        description="Mean temperature of the section",
        json_schema_extra=unit("°C"),
    )

    def points(self) -> SetPoints:
        """The same as numbers that are judged by."""
        return SetPoints(
            target_mm=self.target_mm,
            tolerance_plus_mm=self.tolerance_plus_mm,
            tolerance_minus_mm=self.tolerance_minus_mm,
            temperature_c=self.temperature_c,
            grade=grade_of(self.grade) if self.grade else None,
        )


class CorrectionSettings(Section):
    """The advised change of the stand's gap."""

    gain: float = Field(default=0.5, ge=0, le=2, description="Share of the deviation that is corrected")
    dead_band_mm: float = Field(
        default=0.1, ge=0, le=10, description="Deviation that is left alone", json_schema_extra=unit("mm")
    )
    rate_mm_per_s: float = Field(
        default=0.5, gt=0, le=100, description="Fastest change of correction", json_schema_extra=unit("mm/s")
    )
    limit_mm: float = Field(
        default=1.0, ge=0, le=50, description="Largest correction either way", json_schema_extra=unit("mm")
    )
