"""Settings of network and USB cameras."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import AfterValidator, Field

from appliance.cameras.section import PairCamera, PictureCamera
from appliance.settings.section import FilePath, Section, unit

if TYPE_CHECKING:
    from appliance.cameras.source import PairSource, PictureSource
    from appliance.cameras.stream.reader import StreamPlace


def _without_credentials(address: str) -> str:
    if "://" in address and "@" in address:
        raise ValueError("an address with user or password would be read by everybody; name a file in credentials")
    return address


StreamAddress = Annotated[str, AfterValidator(_without_credentials)]
"""Where a stream is, without user and password."""


class _Stream(Section):
    """How streams are received."""

    credentials: FilePath | None = Field(
        default=None,
        description="File with the user in its first line and the password in its second, for the service only to read",
    )
    transport: Literal["tcp", "udp"] = Field(default="tcp", description="What carries the packets of an RTSP stream")
    clock: Literal["arrival", "camera"] = Field(
        default="arrival",
        description="What tells when a picture was exposed: presentation times tied to arrivals, or the camera's own "
        "clock (RTCP), which a time server must keep in step with this computer's",
    )
    delay_ms: float = Field(
        default=100.0,
        ge=0,
        le=2000,
        description="Time from exposure to arrival; it counts to the age of a reading",
        json_schema_extra=unit("ms"),
    )

    def place(self, address: str) -> "StreamPlace":
        """Return where a stream of these settings is and how it is received."""
        from appliance.cameras.stream.reader import StreamPlace

        file: Path | None = self.credentials
        return StreamPlace(address, file, self.transport, self.clock == "camera", self.delay_ms / 1000)


class StreamCamera(PairCamera, _Stream):
    """Network or USB cameras."""

    kind: Literal["stream"] = Field(description="RTSP or HTTP streams, or V4L2 devices")
    left: StreamAddress = Field(
        description="Left camera: an address such as rtsp://..., or a device such as /dev/video0"
    )
    right: StreamAddress = Field(description="Right camera")

    @property
    def in_words(self) -> str:
        """Two streams."""
        return "two streams"

    def make_source(self, in_step_us: float, /) -> "PairSource":
        """Image pairs of two streams; see `PairCamera.make_source`."""
        from appliance.cameras.stream.source import StreamSource

        return StreamSource(self, in_step_us)


class StreamPictures(PictureCamera, _Stream):
    """A network or USB camera."""

    kind: Literal["stream"] = Field(description="RTSP or HTTP stream, or a V4L2 device")
    address: StreamAddress = Field(description="An address such as rtsp://..., or a device such as /dev/video0")

    @property
    def in_words(self) -> str:
        """One stream."""
        return "a stream"

    def make_source(self) -> "PictureSource":
        """Pictures of one stream; see `PictureCamera.make_source`."""
        from appliance.cameras.stream.source import StreamPictureSource

        return StreamPictureSource(self)
