"""Settings of recordings in place of cameras."""

from typing import TYPE_CHECKING, Literal

from pydantic import Field

from appliance.cameras.section import EmptyLine, PairCamera, PictureCamera
from appliance.settings.section import FilePath, unit

if TYPE_CHECKING:
    from appliance.cameras.source import PairSource, PictureSource


class RecordingCamera(PairCamera):
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

    @property
    def in_words(self) -> str:
        """The recording, by its folder."""
        return f"the recording {self.path}"

    def make_source(self, _in_step_us: float, /) -> "PairSource":
        """Recorded image pairs; see `PairCamera.make_source`."""
        from appliance.cameras.recording.pairs import RecordingSource

        return RecordingSource(self.path, rate_hz=self.rate_hz, loop=self.loop)


class RecordedPictures(PictureCamera):
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

    @property
    def in_words(self) -> str:
        """The recording, by its folder."""
        return f"the recording {self.path}"

    def make_source(self) -> "PictureSource":
        """Recorded pictures; see `PictureCamera.make_source`."""
        from appliance.cameras.recording.pictures import PictureRecordingSource

        return PictureRecordingSource(self.path, rate_hz=self.rate_hz, loop=self.loop)

    def own_empty_line(self) -> EmptyLine:
        """The recording's darkest pictures; raises `CameraError` when it cannot be read."""
        from appliance.cameras.recording.pictures import PictureRecording, darkest

        return EmptyLine(darkest(PictureRecording(self.path)), f"the darkest pictures of {self.path}")
