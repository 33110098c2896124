"""Settings of network and USB cameras."""

from typing import Literal

from pydantic import Field

from appliance.settings.section import Section, unit


class StreamCamera(Section):
    """Network or USB cameras through OpenCV."""

    kind: Literal["stream"] = Field(description="RTSP or HTTP streams, or V4L2 devices")
    left: str = Field(description="Left camera: an address such as rtsp://..., or a device such as /dev/video0")
    right: str = Field(description="Right camera")
    delay_ms: float = Field(
        default=100.0,
        ge=0,
        le=2000,
        description="Time from exposure to arrival; it counts to the age of a reading",
        json_schema_extra=unit("ms"),
    )


class StreamPictures(Section):
    """A network or USB camera through OpenCV."""

    kind: Literal["stream"] = Field(description="RTSP or HTTP stream, or a V4L2 device")
    address: str = Field(description="An address such as rtsp://..., or a device such as /dev/video0")
    delay_ms: float = Field(
        default=100.0,
        ge=0,
        le=2000,
        description="Time from exposure to arrival; it counts to the age of a reading",
        json_schema_extra=unit("ms"),
    )
