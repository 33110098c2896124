"""Settings of the trust in pictures and of their exposure, whichever kind of camera takes them."""

from pydantic import Field, ValidationInfo, field_validator

from appliance.settings.section import Section, unit


class LivenessSettings(Section):
    """When the pictures of the cameras are no longer believed."""

    lost_after_ms: int = Field(
        default=700,
        ge=100,
        le=10000,
        description="Time without a valid picture (new, in step, not blank) after which the camera counts as lost",
        json_schema_extra=unit("ms"),
    )
    apart_max_us: int = Field(
        default=5000,
        ge=1,
        le=1000000,
        description="Longest time between left and right exposure of a pair, by their device time stamps",
        json_schema_extra=unit("µs"),
    )
    blank_level: int = Field(
        default=2,
        ge=0,
        le=255,
        description="Steps of grey by which nearly all pixels of a blank picture stay within its median",
    )
    interval_max_ms: int = Field(
        default=500,
        ge=10,
        le=60000,
        description="Mean time between pairs above which they come too slowly",
        json_schema_extra=unit("ms"),
    )
    dropped_max_percent: float = Field(
        default=75.0,
        ge=0,
        le=100,
        description="Share of dropped pairs above which a fault is raised",
        json_schema_extra=unit("%"),
    )
    idle_after_s: float = Field(
        default=15.0,
        ge=1,
        le=600,
        description="Time without a reading and without a fault after which a measuring process is started again",
        json_schema_extra=unit("s"),
    )


class ExposureSettings(Section):
    """How bright the bar's edges may be."""

    clipped_max_percent: float = Field(
        default=5.0,
        ge=0,
        le=100,
        description="Largest share of one edge of the bar that may be overexposed",
        json_schema_extra=unit("%"),
    )
    light_min: float = Field(
        default=0.1, ge=0, le=1, description="Least light of the bar beside its edges, over full scale"
    )
    after_s: float = Field(
        default=10.0,
        ge=0,
        le=3600,
        description="Time for which edges stay too bright or too dark before a fault, or before exposure changes",
        json_schema_extra=unit("s"),
    )
    control: bool = Field(default=False, description="Change the exposure of cameras that allow it, step by step")
    shortest_us: float = Field(
        default=50.0, ge=1, le=33000, description="Shortest exposure that control sets", json_schema_extra=unit("µs")
    )
    longest_us: float = Field(
        default=2000.0, ge=1, le=33000, description="Longest exposure that control sets", json_schema_extra=unit("µs")
    )

    @field_validator("longest_us")
    @classmethod
    def _not_below_shortest(cls, longest_us: float, info: ValidationInfo) -> float:
        shortest_us = info.data.get("shortest_us", longest_us)
        if longest_us < shortest_us:
            raise ValueError(f"it is below shortest_us = {shortest_us:g}")
        return longest_us
