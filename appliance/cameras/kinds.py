"""The table of camera kinds: those that give image pairs, and those that give single pictures, by their use."""

from typing import Annotated

from pydantic import Field

from appliance.cameras.genicam.settings import GenicamCamera, GenicamPictures
from appliance.cameras.oak.settings import OakCamera, OakPictures
from appliance.cameras.off.settings import NoCamera
from appliance.cameras.recording.settings import RecordedPictures, RecordingCamera
from appliance.cameras.simulated.settings import MillCamera, MillPictures, MillThermal
from appliance.cameras.stream.settings import StreamCamera, StreamPictures

StereoCamera = Annotated[
    MillCamera | RecordingCamera | OakCamera | StreamCamera | GenicamCamera, Field(discriminator="kind")
]

IngotCamera = Annotated[
    NoCamera | MillPictures | RecordedPictures | OakPictures | StreamPictures | GenicamPictures,
    Field(discriminator="kind"),
]

ConveyorCamera = Annotated[
    MillThermal | RecordedPictures | OakPictures | StreamPictures | GenicamPictures, Field(discriminator="kind")
]
