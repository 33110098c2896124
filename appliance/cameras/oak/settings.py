"""Settings of OAK cameras: as a pair, and one sensor alone."""

import contextlib
from collections.abc import Generator
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from appliance.cameras.section import PairCamera, PictureCamera
from appliance.settings.section import Section, unit

if TYPE_CHECKING:
    from appliance.cameras.source import PairSource, PictureSource

OakSocket = Literal["CAM_A", "CAM_B", "CAM_C", "CAM_D"]


class _OakSensor(Section):
    """What is fixed for every sensor of an OAK camera."""

    rate_hz: float = Field(
        default=10.0, gt=0, le=120, description="Exposures per second", json_schema_extra=unit("1/s")
    )
    exposure_us: int = Field(default=500, ge=1, le=33000, description="Exposure time", json_schema_extra=unit("µs"))
    sensitivity_iso: int = Field(default=100, ge=100, le=1600, description="Sensitivity, as ISO value")
    white_balance_k: int = Field(
        default=5000, ge=1000, le=12000, description="White balance", json_schema_extra=unit("K")
    )
    focus: int = Field(
        default=130, ge=0, le=255, description="Position of the lens; one of fixed focus has no use for it"
    )


class OakCamera(PairCamera, _OakSensor):
    """OAK cameras."""

    kind: Literal["oak"] = Field(description="OAK cameras, through depthai")
    left: str = Field(default="", description="Left camera: device id, address or name; empty takes the only device")
    right: str = Field(default="", description="Right camera; empty: both sensors are those of the left device")
    left_socket: OakSocket = Field(default="CAM_B", description="Sensor that is the left camera")
    right_socket: OakSocket = Field(default="CAM_C", description="Sensor that is the right camera")
    sync: Literal["wire", "ptp"] = Field(
        default="wire", description="What keeps two devices in step: the FSYNC wire from left to right, or PTP"
    )
    pictures: Literal["grey", "colour"] = Field(
        default="grey", description="Kind of pictures; grey has the sharper edges"
    )

    @property
    def in_words(self) -> str:
        """OAK cameras."""
        return "OAK cameras"

    def make_source(self, in_step_us: float, /) -> "PairSource":
        """Image pairs of OAK cameras; see `PairCamera.make_source`."""
        with depthai():
            from appliance.cameras.oak.source import OakSource
        return OakSource(self, in_step_us)


class OakPictures(PictureCamera, _OakSensor):
    """One sensor of an OAK camera."""

    kind: Literal["oak"] = Field(description="An OAK camera, through depthai")
    device: str = Field(default="", description="Device id, address or name; empty takes the only device")
    socket: OakSocket = Field(default="CAM_A", description="Sensor that takes the pictures")

    @property
    def in_words(self) -> str:
        """One OAK camera."""
        return "an OAK camera"

    def make_source(self) -> "PictureSource":
        """Pictures of one sensor; see `PictureCamera.make_source`."""
        with depthai():
            from appliance.cameras.oak.source import OakPictureSource
        return OakPictureSource(self)


@contextlib.contextmanager
def depthai() -> Generator[None]:
    """Turn a failed import of the extra library into a `CameraError` that says how to install it."""
    from appliance.cameras.source import CameraError

    try:
        yield
    except ImportError as error:
        raise CameraError("depthai is not installed; install it with: pip install depthai") from error
