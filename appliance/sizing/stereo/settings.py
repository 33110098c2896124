"""Settings of the sizing station with two calibrated cameras."""

from typing import Literal

from pydantic import Field

from appliance.cameras.kinds import Camera
from appliance.cameras.simulated.settings import MillCamera
from appliance.processes.settings import StationSettings
from appliance.settings.section import FilePath


class SizingSettings(StationSettings):
    """The sizing station with two cameras."""

    method: Literal["tangent"] = Field(
        default="tangent", description="Two calibrated cameras; the method without this key"
    )

    camera: Camera = Field(default_factory=MillCamera, description="Where image pairs come from")
    rig: FilePath | None = Field(
        default=None,
        description="Calibration of the two cameras, from `hotgauge calibrate`; the mill can do without",
    )
