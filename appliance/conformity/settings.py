"""Settings of trust, cold size, bars and the advised correction."""

from pydantic import Field

from appliance.settings.section import Section, unit
from vision.sizing.bar_gap import GAP_S


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
        default=round(1000 * GAP_S),
        ge=0,
        le=60000,
        description="Time without a bar in view after which the next reading begins a new bar",
        json_schema_extra=unit("ms"),
    )


class CorrectionSettings(Section):
    """The advised change of the stand's gap."""

    gain: float = Field(default=0.5, ge=0, le=2, description="Share of the deviation that is corrected")
    dead_band_mm: float = Field(
        default=0.1, ge=0, le=10, description="Deviation up to which nothing is corrected", json_schema_extra=unit("mm")
    )
    rate_mm_per_s: float = Field(
        default=0.5, gt=0, le=100, description="Fastest change of correction", json_schema_extra=unit("mm/s")
    )
    limit_mm: float = Field(
        default=1.0, ge=0, le=50, description="Largest correction either way", json_schema_extra=unit("mm")
    )
