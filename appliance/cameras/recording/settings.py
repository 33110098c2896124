"""Settings of recordings in place of cameras."""

from typing import Literal

from pydantic import Field

from appliance.settings.section import FilePath, Section, unit


class RecordingCamera(Section):
    """A recording as camera."""

    kind: Literal["recording"] = Field(description="Pictures recorded before")
    path: FilePath = Field(description="Folder with left/ and right/ pictures, or left.mp4 and right.mp4")
    rate_hz: float = Field(
        default=10.0,
        ge=0,
        le=1000,
        description="Image pairs per second; 0 plays as fast as the gauge takes them",
        json_schema_extra=unit("1/s"),
    )
    loop: bool = Field(default=True, description="Start again at the end")


class RecordedPictures(Section):
    """A recording of one camera as camera."""

    kind: Literal["recording"] = Field(description="Pictures recorded before")
    path: FilePath = Field(description="Folder with pictures 000000.png or .jpg and so on")
    rate_hz: float = Field(
        default=5.0,
        ge=0,
        le=1000,
        description="Pictures per second; 0 plays as fast as the station takes them",
        json_schema_extra=unit("1/s"),
    )
    loop: bool = Field(default=True, description="Start again at the end")
