"""Settings of the sizing station with one camera between barriers."""

from typing import Literal

from pydantic import Field

from appliance.cameras.kinds import ConveyorCamera
from appliance.cameras.simulated.settings import MillThermal
from appliance.processes.settings import StationSettings
from appliance.settings.section import FilePath, Section, unit


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


class ConveyorSettings(StationSettings):
    """The sizing station with one camera over a conveyor between barriers."""

    method: Literal["conveyor"] = Field(description="One camera, not calibrated, over a conveyor between two barriers")
    camera: ConveyorCamera = Field(default_factory=MillThermal, description="Where pictures come from")
    conveyor: ConveyorLine = Field(description="What is known of the line")
