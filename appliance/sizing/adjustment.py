"""A known error of a calibration, taken off every diameter, with its date, its reason and who decided it."""

import math
from dataclasses import replace
from datetime import date
from typing import Self

from pydantic import Field, model_validator

from appliance.settings.section import Section, unit
from vision.readings import SizeReading
from vision.reasons import Reason


class Adjustment(Section):
    """What a verification found to be wrong everywhere, and is therefore added to every diameter.

    It belongs to one calibration: an error that was found with another says nothing of this one.

    Examples
    --------
    >>> from vision.readings import SizeReading
    >>> who = {"date": "2026-11-28", "reason": "master 250.00", "who": "A. Smith", "calibration_sha256": "5e" * 32}
    >>> known = Adjustment(added_mm=-0.12, expanded_mm=0.03, **who)
    >>> reading = known.adjusted(SizeReading(diameter_mm=250.12, expanded_uncertainty_mm=0.04, u_model_mm=0.0))
    >>> round(reading.diameter_mm, 3), round(reading.expanded_uncertainty_mm, 3), reading.reasons.names
    (250.0, 0.05, ['adjusted'])
    """

    added_mm: float = Field(
        default=0.0,
        ge=-5,
        le=5,
        description="Added to every diameter: master minus mean of a verification; 0: none",
        json_schema_extra=unit("mm"),
    )
    expanded_mm: float = Field(
        default=0.0,
        ge=0,
        le=5,
        description="Its expanded uncertainty (k = 2), from the same verification; part of the reading's",
        json_schema_extra=unit("mm"),
    )
    date: str = Field(default="", description="Day of the verification, as 2026-11-28")
    reason: str = Field(default="", description="Why, and by which master")
    who: str = Field(default="", description="Who decided it")
    calibration_sha256: str = Field(
        default="",
        pattern="^([0-9a-f]{64})?$",
        description="SHA-256 of the rig or picture of the empty line that it was found with, as verify tells it; "
        "with another no value is served",
    )

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        if self.added_mm == 0:
            return self
        missing = [
            name for name in ("expanded_mm", "date", "reason", "who", "calibration_sha256") if not getattr(self, name)
        ]
        if missing:
            raise ValueError(f"added_mm is not 0, so that {' and '.join(missing)} must be given")
        try:
            date.fromisoformat(self.date)
        except ValueError as error:
            raise ValueError(f"date is {self.date!r}; write the day as 2026-11-28") from error
        return self

    def refusal(self, calibration_sha256: str) -> str:
        """Why the adjustment must not be used with a calibration; empty if it may, or is none.

        Parameters
        ----------
        calibration_sha256 : str
            SHA-256 of the file, hexadecimal; empty where there is no file.
        """
        if self.added_mm == 0 or self.calibration_sha256 == calibration_sha256:
            return ""
        other = f"the one with SHA-256 {calibration_sha256[:12]}..." if calibration_sha256 else "a gauge without a file"
        return (
            f"sizing.adjustment.added_mm is {self.added_mm:g}, the known error of the calibration with SHA-256 "
            f"{self.calibration_sha256[:12]}... and not of {other}; set it to 0 or to what hotgauge verify finds now"
        )

    def adjusted(self, reading: SizeReading) -> SizeReading:
        """The reading with the adjustment in all that the diameter decides; one without a value as it is.

        Both widths change with the diameter, for the mean of a section that turns is made of them. The axis rises by
        half of it: the verification has shown nothing of the bar's lowest point, which stays where it was measured.

        Parameters
        ----------
        reading : SizeReading
        """
        if self.added_mm == 0 or not math.isfinite(reading.diameter_mm):
            return reading
        return replace(
            reading,
            diameter_mm=reading.diameter_mm + self.added_mm,
            width_left_mm=reading.width_left_mm + self.added_mm,
            width_right_mm=reading.width_right_mm + self.added_mm,
            axis_height_mm=reading.axis_height_mm + self.added_mm / 2,
            expanded_uncertainty_mm=math.hypot(reading.expanded_uncertainty_mm, self.expanded_mm),
            u_model_mm=math.hypot(reading.u_model_mm, self.expanded_mm / 2),
            reasons=reading.reasons | Reason.ADJUSTED,
        )
