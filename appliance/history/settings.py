"""Settings of the history."""

from typing import Self

from pydantic import Field, model_validator

from appliance.settings.section import FilePath, Section, unit


class HistorySettings(Section):
    """What is kept on disk of what was measured, and for how long."""

    directory: FilePath | None = Field(
        default=None, description="Folder of the history; without one nothing is kept on disk"
    )
    reading_period_s: float = Field(
        default=0.5,
        ge=0,
        le=3600,
        description="Of a bar one reading in this time is kept, and every one whose validity, reasons or decision "
        "differ from those of the reading before it; 0 keeps all",
        json_schema_extra=unit("s"),
    )
    verification_due_days: int = Field(
        default=0,
        ge=0,
        le=3650,
        description="Time after which a calibration is due unless hotgauge verify has passed on it; 0: never by time. "
        "One that failed makes it due in any case",
        json_schema_extra=unit("days"),
    )
    days: int = Field(
        default=400,
        ge=1,
        le=36500,
        description="Age above which rows are deleted; verifications stay",
        json_schema_extra=unit("days"),
    )
    size_max_mb: int = Field(
        default=4000,
        ge=10,
        le=1000000,
        description="Size of the database above which the oldest readings are deleted",
        json_schema_extra=unit("MB"),
    )

    @model_validator(mode="after")
    def _is_kept_where_it_is_needed(self) -> Self:
        if self.verification_due_days and self.directory is None:
            raise ValueError(
                "verification_due_days needs the history, which keeps verifications; give directory, or leave it out"
            )
        return self
