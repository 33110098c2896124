"""Settings that every measuring process has."""

from pydantic import Field

from appliance.cameras.settings import ExposureSettings, LivenessSettings
from appliance.settings.section import Section, unit


class StationSettings(Section):
    """What a sizing station has with any method."""

    ovality_mm: float = Field(
        default=0.0,
        ge=0,
        le=20,
        description="Greatest minus least width of a section that the product may have; part of the uncertainty",
        json_schema_extra=unit("mm"),
    )
    stale_after_ms: int = Field(
        default=800,
        ge=100,
        le=10000,
        description="Age from which a reading is no value any more",
        json_schema_extra=unit("ms"),
    )
    memory_max_mb: int = Field(
        default=2048,
        ge=256,
        le=65536,
        description="Memory of each measuring process, above which it ends and is started again",
        json_schema_extra=unit("MB"),
    )
    liveness: LivenessSettings = Field(default_factory=LivenessSettings, description="When pictures are believed")
    exposure: ExposureSettings = Field(default_factory=ExposureSettings, description="How bright edges may be")
    camera_temperature_max_c: float = Field(
        default=75.0,
        ge=0,
        le=120,
        description="Temperature of a camera above which it is too hot",
        json_schema_extra=unit("°C"),
    )
