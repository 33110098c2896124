"""Settings of GenICam cameras: as a pair, and one alone."""

import contextlib
from collections.abc import Generator
from typing import TYPE_CHECKING, Literal, Self

from pydantic import Field, model_validator

from appliance.cameras.genicam.trigger import ACTION
from appliance.cameras.section import PairCamera, PictureCamera
from appliance.settings.section import Box, Section, unit

if TYPE_CHECKING:
    from appliance.cameras.source import PairSource, PictureSource

PixelFormat = Literal[
    "Mono8", "Mono10", "Mono12", "Mono16",
    "BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8",
    "BayerRG10", "BayerGR10", "BayerGB10", "BayerBG10",
    "BayerRG12", "BayerGR12", "BayerGB12", "BayerBG12",
    "BayerRG16", "BayerGR16", "BayerGB16", "BayerBG16",
]  # fmt: skip
"""Formats whose code values are the sensor's own (GenICam PFNC), one to a pixel, not packed."""


class GenicamSection(Section):
    """What is fixed for every camera."""

    pixel_format: PixelFormat = Field(default="Mono8", description="Format of the pictures, as the sensor takes them")
    rate_hz: float = Field(
        default=10.0, gt=0, le=500, description="Exposures per second without a trigger", json_schema_extra=unit("1/s")
    )
    exposure_us: float = Field(default=500.0, ge=1, le=33000, description="Exposure time", json_schema_extra=unit("µs"))
    gain_db: float = Field(default=0.0, ge=0, le=48, description="Gain", json_schema_extra=unit("dB"))
    black_level: float = Field(
        default=0.0, ge=0, le=4096, description="Code value of darkness, where the camera has such a setting"
    )
    region: Box = Field(default=[], description="Part of the sensor that is read out; []: all of it")
    trigger: str = Field(
        default="",
        description="What fires each exposure: an input such as Line0; Software or Action1: this computer, rate_hz "
        "times a second, each camera by its own command or all by one; empty: the camera runs freely",
    )
    packet_bytes: int = Field(
        default=0,
        ge=0,
        le=16110,
        description="Size of a GigE camera's packets; 0: the largest that the network carries",
        json_schema_extra=unit("bytes"),
    )
    chunk_data: bool = Field(
        default=False, description="Have the camera send its exposure time with each picture, where it can"
    )
    delay_ms: float = Field(
        default=10.0,
        ge=0,
        le=2000,
        description="Time from exposure to the arrival of a picture that did not wait; it counts to a reading's age",
        json_schema_extra=unit("ms"),
    )

    @property
    def wants_ptp(self) -> bool:
        """Whether the camera keeps its clock in step with another's."""
        return False

    @property
    def ahead_s(self) -> float:
        """How long before the exposure an action command is sent; 0: the camera exposes when it arrives."""
        return 0.0


class GenicamCamera(PairCamera, GenicamSection):
    """GenICam cameras."""

    kind: Literal["genicam"] = Field(description="GigE Vision or USB3 Vision cameras, through Aravis")
    left: str = Field(description="Serial number of the left camera")
    right: str = Field(description="Serial number of the right camera")
    common_clock: bool = Field(
        default=False,
        description="Whether both cameras' clocks are kept in step, so that their time stamps make the pairs; PTP is "
        "switched on where a camera has it",
    )

    scheduled_ms: float = Field(
        default=0.0,
        ge=0,
        le=1000,
        description="How long before the exposure an action command is sent; it carries the moment by the cameras' "
        "common clock, so that a busy computer or network does not shift it; 0: cameras expose when it arrives",
        json_schema_extra=unit("ms"),
    )

    @model_validator(mode="after")
    def _schedules_with_a_clock(self) -> Self:
        if self.scheduled_ms and not (self.common_clock and self.trigger == ACTION):
            raise ValueError(f'scheduled_ms needs trigger = "{ACTION}" and common_clock = true')
        return self

    @property
    def wants_ptp(self) -> bool:
        """Whether the cameras keep their clocks in step."""
        return self.common_clock

    @property
    def ahead_s(self) -> float:
        """How long before the exposure an action command is sent."""
        return self.scheduled_ms / 1000

    @property
    def in_words(self) -> str:
        """GenICam cameras."""
        return "GenICam cameras"

    def make_source(self, in_step_us: float, /) -> "PairSource":
        """Image pairs of two cameras; see `PairCamera.make_source`."""
        with aravis():
            from appliance.cameras.genicam.source import GenicamSource
        return GenicamSource(self, in_step_us)


class GenicamPictures(PictureCamera, GenicamSection):
    """A GenICam camera."""

    kind: Literal["genicam"] = Field(description="A GigE Vision or USB3 Vision camera, through Aravis")
    serial: str = Field(description="Serial number of the camera")

    @property
    def in_words(self) -> str:
        """One GenICam camera."""
        return "a GenICam camera"

    def make_source(self) -> "PictureSource":
        """Pictures of one camera; see `PictureCamera.make_source`."""
        with aravis():
            from appliance.cameras.genicam.source import GenicamPictureSource
        return GenicamPictureSource(self)


@contextlib.contextmanager
def aravis() -> Generator[None]:
    """Turn a failed import of the extra library into a `CameraError` that says how to install it."""
    from appliance.cameras.source import CameraError

    try:
        yield
    except (ImportError, ValueError) as error:  # PyGObject is missing, or Aravis' description is
        raise CameraError(
            "Aravis is not installed; install it with: apt-get install gir1.2-aravis-0.8 libgirepository1.0-dev "
            "libcairo2-dev, then pip install 'PyGObject<3.51'"
        ) from error
