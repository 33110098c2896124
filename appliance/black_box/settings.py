"""Settings of a station's black box."""

from pydantic import Field

from appliance.settings.section import FilePath, Section, unit


class BlackBoxSettings(Section):
    """The last seconds of pictures, written on an alarm, on a decision "out", and when they are asked for."""

    directory: FilePath | None = Field(
        default=None, description="Folder of the recordings; without one no pictures are kept"
    )
    seconds: float = Field(
        default=5.0,
        ge=0.5,
        le=300,
        description="Time that a recording covers, the last second of it after its cause",
        json_schema_extra=unit("s"),
    )
    memory_max_mb: int = Field(
        default=512,
        ge=16,
        le=32768,
        description="Memory of pictures, half of it for those that are being written; part of memory_max_mb of the "
        "station. With too little a recording is shorter",
        json_schema_extra=unit("MB"),
    )
    recordings_max: int = Field(
        default=20, ge=1, le=10000, description="Recordings of this station; above it the oldest is deleted"
    )
    size_max_mb: int = Field(
        default=4000,
        ge=10,
        le=1000000,
        description="Size of all recordings of this station, above which the oldest is deleted",
        json_schema_extra=unit("MB"),
    )
    again_after_s: float = Field(
        default=60.0,
        ge=0,
        le=86400,
        description="Time after a recording in which the same cause writes no other",
        json_schema_extra=unit("s"),
    )
