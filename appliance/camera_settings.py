"""Settings of cameras, of those that give pairs and of those that give single pictures, and of trust in them."""

from typing import Annotated, Literal

from pydantic import Field

from appliance.sections import FilePath, Section, unit


class MillCamera(Section):
    """The simulated mill as camera."""

    kind: Literal["mill"] = Field(default="mill", description="A simulated mill, for trying and testing")
    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="Seed of bars and noise")
    rate_hz: float = Field(
        default=10.0, gt=0, le=60, description="Image pairs per second", json_schema_extra=unit("1/s")
    )
    prepared_frames: int = Field(
        default=0,
        ge=0,
        le=600,
        description="Frames drawn before the start and then played as a loop, at any rate; 0 draws as it goes",
    )


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


class OakCamera(_OakSensor):
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


Camera = Annotated[MillCamera | RecordingCamera | OakCamera | StreamCamera, Field(discriminator="kind")]


class NoCamera(Section):
    """No camera: the station is off."""

    kind: Literal["off"] = Field(default="off", description="No ingot station")


class MillPictures(Section):
    """The simulated ingot line as camera."""

    kind: Literal["mill"] = Field(description="A simulated ingot line, for trying and testing")
    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="Seed of line, ingots and noise")
    rate_hz: float = Field(default=5.0, gt=0, le=60, description="Pictures per second", json_schema_extra=unit("1/s"))


class MillThermal(Section):
    """The simulated thermal line as camera."""

    kind: Literal["mill"] = Field(
        default="mill", description="A simulated thermal line, barriers 600 mm apart and 100 mm high, for trying"
    )
    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="Seed of bars and noise")
    rate_hz: float = Field(default=10.0, gt=0, le=60, description="Pictures per second", json_schema_extra=unit("1/s"))


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


class OakPictures(_OakSensor):
    """One sensor of an OAK camera."""

    kind: Literal["oak"] = Field(description="An OAK camera, through depthai")
    device: str = Field(default="", description="Device id, address or name; empty takes the only device")
    socket: OakSocket = Field(default="CAM_A", description="Sensor that takes the pictures")


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


PictureCamera = Annotated[
    NoCamera | MillPictures | RecordedPictures | OakPictures | StreamPictures, Field(discriminator="kind")
]

ConveyorCamera = Annotated[MillThermal | RecordedPictures | OakPictures | StreamPictures, Field(discriminator="kind")]


class LivenessSettings(Section):
    """When the pictures of the cameras are no longer believed."""

    lost_after_ms: int = Field(
        default=700,
        ge=100,
        le=10000,
        description="Time without a picture that counts (new, in step, not blank) after which it is a fault",
        json_schema_extra=unit("ms"),
    )
    apart_max_us: int = Field(
        default=5000,
        ge=1,
        le=1000000,
        description="Longest time between left and right exposure of a pair, by their device time stamps",
        json_schema_extra=unit("µs"),
    )
    blank_level: int = Field(
        default=2,
        ge=0,
        le=255,
        description="Steps of grey by which nearly all pixels of a blank picture stay within its median",
    )
    interval_max_ms: int = Field(
        default=500,
        ge=10,
        le=60000,
        description="Mean time between pairs above which they come too slowly",
        json_schema_extra=unit("ms"),
    )
    dropped_max_percent: float = Field(
        default=75.0,
        ge=0,
        le=100,
        description="Share of dropped pairs that is a fault",
        json_schema_extra=unit("%"),
    )
    idle_after_s: float = Field(
        default=15.0,
        ge=1,
        le=600,
        description="Time that a measuring process may run without a reading and without a fault",
        json_schema_extra=unit("s"),
    )


class ExposureSettings(Section):
    """How bright the bar's edges may be."""

    clipped_max_percent: float = Field(
        default=5.0,
        ge=0,
        le=100,
        description="Share of an edge of the bar that may be overexposed",
        json_schema_extra=unit("%"),
    )
    light_min: float = Field(
        default=0.1, ge=0, le=1, description="Least light of the bar beside its edges, over full scale"
    )
    after_s: float = Field(
        default=10.0,
        ge=0,
        le=3600,
        description="Time that this must last before it is a fault, or the exposure is changed",
        json_schema_extra=unit("s"),
    )
    control: bool = Field(default=False, description="Change the exposure of cameras that allow it, step by step")
    shortest_us: float = Field(
        default=50.0, ge=1, le=33000, description="Shortest exposure that control sets", json_schema_extra=unit("µs")
    )
    longest_us: float = Field(
        default=2000.0, ge=1, le=33000, description="Longest exposure that control sets", json_schema_extra=unit("µs")
    )
