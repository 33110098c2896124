"""Settings of the sizing station, by the method that measures; `appliance.settings` holds the others and the file."""

from typing import Annotated, Literal, cast

from pydantic import BeforeValidator, Field

from appliance.camera_settings import (
    Camera,
    ConveyorCamera,
    ExposureSettings,
    LivenessSettings,
    MillCamera,
    MillThermal,
)
from appliance.sections import FilePath, Section, unit


class _Station(Section):
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


class SizingSettings(_Station):
    """The sizing station with two cameras."""

    method: Literal["tangent"] = Field(
        default="tangent", description="Two calibrated cameras; the method without this key"
    )

    camera: Camera = Field(default_factory=MillCamera, description="Where image pairs come from")
    rig: FilePath | None = Field(
        default=None,
        description="Calibration of the two cameras, from `hotgauge calibrate`; the mill can do without",
    )


class ConveyorLine(Section):
    """The line under a camera that nobody calibrated: two barriers are its ruler."""

    barrier_mm: float = Field(
        ge=50, le=10000, description="Distance of the barriers' inner faces", json_schema_extra=unit("mm")
    )
    barrier_height_mm: float = Field(
        default=0.0,
        ge=0,
        le=2000,
        description="Height of the barriers' upper inner edges over the conveyor; 0: not known, and far less exact",
        json_schema_extra=unit("mm"),
    )
    camera_height_mm: float = Field(
        default=0.0,
        ge=0,
        le=50000,
        description="Height of the camera's lens over the conveyor; 0: not known",
        json_schema_extra=unit("mm"),
    )
    compensation_mm: float = Field(
        default=0.0, ge=-50, le=50, description="Added to every diameter", json_schema_extra=unit("mm")
    )
    background: FilePath | None = Field(
        default=None,
        description="Picture of the line without a bar, by this camera; recordings and the mill can do without",
    )


class ConveyorSettings(_Station):
    """The sizing station with one camera over a conveyor between barriers."""

    method: Literal["conveyor"] = Field(description="One camera, not calibrated, over a conveyor between two barriers")
    camera: ConveyorCamera = Field(default_factory=MillThermal, description="Where pictures come from")
    conveyor: ConveyorLine = Field(description="What is known of the line")


def _tangent_unless_given(values: object) -> object:
    return {"method": "tangent"} | cast("dict[str, object]", values) if isinstance(values, dict) else values


Sizing = Annotated[
    Annotated[SizingSettings | ConveyorSettings, Field(discriminator="method")], BeforeValidator(_tangent_unless_given)
]
