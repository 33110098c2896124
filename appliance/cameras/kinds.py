"""Settings of cameras, of those that give pairs and of those that give single pictures, and of trust in them."""

from typing import Annotated, Literal

from pydantic import Field

from appliance.cameras.oak.settings import OakCamera, OakPictures
from appliance.cameras.recording.settings import RecordedPictures, RecordingCamera
from appliance.cameras.simulated.settings import MillCamera, MillPictures, MillThermal
from appliance.cameras.stream.settings import StreamCamera, StreamPictures
from appliance.settings.section import Section

Camera = Annotated[MillCamera | RecordingCamera | OakCamera | StreamCamera, Field(discriminator="kind")]


class NoCamera(Section):
    """No camera: the station is off."""

    kind: Literal["off"] = Field(default="off", description="No ingot station")


PictureCamera = Annotated[
    NoCamera | MillPictures | RecordedPictures | OakPictures | StreamPictures, Field(discriminator="kind")
]

ConveyorCamera = Annotated[MillThermal | RecordedPictures | OakPictures | StreamPictures, Field(discriminator="kind")]
