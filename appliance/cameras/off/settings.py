"""Settings of a station without a camera."""

from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field

from appliance.cameras.section import PictureCamera

if TYPE_CHECKING:
    from appliance.cameras.source import PictureSource


class NoCamera(PictureCamera):
    """No camera: the station is off."""

    is_on: ClassVar[bool] = False

    kind: Literal["off"] = Field(default="off", description="No ingot station")

    @property
    def in_words(self) -> str:
        """No camera."""
        return "no camera"

    def make_source(self) -> "PictureSource":
        """Raise `CameraError`: a station that is off has no pictures."""
        from appliance.cameras.source import CameraError

        raise CameraError("ingot.camera.kind is off; give a camera")
