"""Settings of network and USB cameras."""

from typing import TYPE_CHECKING, Literal

from pydantic import Field

from appliance.cameras.section import PairCamera, PictureCamera
from appliance.settings.section import unit

if TYPE_CHECKING:
    from appliance.cameras.source import PairSource, PictureSource


class StreamCamera(PairCamera):
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

    @property
    def in_words(self) -> str:
        """Two streams."""
        return "two streams"

    def make_source(self, in_step_us: float, /) -> "PairSource":
        """Image pairs of two streams; see `PairCamera.make_source`."""
        from appliance.cameras.stream.source import StreamSource

        return StreamSource(self, in_step_us)


class StreamPictures(PictureCamera):
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

    @property
    def in_words(self) -> str:
        """One stream."""
        return "a stream"

    def make_source(self) -> "PictureSource":
        """Pictures of one stream; see `PictureCamera.make_source`."""
        from appliance.cameras.stream.source import StreamPictureSource

        return StreamPictureSource(self)
