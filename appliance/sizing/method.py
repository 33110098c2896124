"""Interface of a sizing method: its camera, its gauge, its part in `replay` and in `doctor`.

A method is a folder here with its settings and a folder in `vision.sizing` with its gauge, a row in
`appliance.sizing.settings` and a row in `appliance.cli.pictures.measure`. The settings load the gauge only when it is
asked for: the supervisor reads settings and must load no image library.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple, Protocol, Self

from pydantic import Field

from appliance.black_box.settings import BlackBoxSettings
from appliance.cameras.settings import ExposureSettings, LivenessSettings
from appliance.errors import HotgaugeError
from appliance.settings.section import Section, unit
from appliance.sizing.adjustment import Adjustment
from appliance.sizing.set_points import SetPointSettings

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from appliance.cameras.source import PairSource, PictureSource
    from appliance.processes.preview import Lines
    from appliance.sizing.range_sensor.sensor import RangeSensor
    from vision.readings import SizeReading


class ScaleError(HotgaugeError):
    """The scale, a rig file or an empty line, cannot be used; the message says what, where and what to do.

    Attributes
    ----------
    fault : str
        Name in the fault table.
    """

    fault: str


class AdjustmentError(ScaleError):
    """The known error that the settings take off was found with another calibration."""

    def __init__(self, sentence: str, fault: str) -> None:
        super().__init__(sentence)
        self.fault = fault


class ScaleCheck(NamedTuple):
    """Check of the scale, a rig file or an empty line, for `doctor`.

    Attributes
    ----------
    name : str
        `rig` or `barriers`.
    verdict : {"good", "note", "BAD"}
    text : str
        What was found, and what to do.
    """

    name: str
    verdict: Literal["good", "note", "BAD"]
    text: str


class ScaleFile(NamedTuple):
    """A file by which a gauge is made again.

    Attributes
    ----------
    setting : str
        Key of the settings that names such a file.
    name : str
        Of its copy.
    content : bytes
        As the gauge uses it, also when the file has changed since.
    """

    setting: str
    name: str
    content: bytes


class TimedReader(Protocol):
    """A gauge that also returns its computing time."""

    @property
    def measure_exposed(self) -> "Callable[..., tuple[tuple[SizeReading, ...], float]]":
        """Measure an exposure of the source: a reading a bar, computing time, ms; raises `ScaleError`."""
        ...

    @property
    def scale_files(self) -> "Sequence[ScaleFile]":
        """Files by which the same gauge is made again beside its settings; none where the camera has its own scale."""
        ...

    @property
    def carried(self) -> tuple[float, ...]:
        """What the next frame gets of the earlier ones; NaN before any."""
        ...

    def resume(self, carried: Sequence[float], /) -> None:
        """Go on as the gauge would whose `carried` this was, so that frames from the middle give the same bits."""
        ...

    def warm_up(self) -> None:
        """Compile and load all that measuring needs."""
        ...

    def lines(self, reading: "SizeReading", /) -> "Lines":
        """What a reading and the scale look like in each picture, left first, for people who aim the cameras."""
        ...


class SizingMethod(Section, ABC):
    """Settings that all sizing methods share, and the functions that each must define.

    Attributes
    ----------
    scale_fault : str
        Fault of a scale that cannot be used, by its name in the fault table.
    """

    scale_fault: ClassVar[str]

    ovality_mm: float | None = Field(
        default=None,
        ge=0,
        le=20,
        description="Greatest minus least width of a section that the product may have, part of the uncertainty; two "
        "cameras assume 0.6 % of the diameter if it is not set",
        json_schema_extra=unit("mm"),
    )
    stale_after_ms: int = Field(
        default=800,
        ge=100,
        le=10000,
        description="Age above which a reading is no longer served as a value",
        json_schema_extra=unit("ms"),
    )
    memory_max_mb: int = Field(
        default=2048,
        ge=256,
        le=65536,
        description="Memory of each measuring process, above which it ends and is started again",
        json_schema_extra=unit("MB"),
    )
    set_points: SetPointSettings = Field(
        default_factory=SetPointSettings, description="What is wanted of a bar if the PLC has not written it"
    )
    liveness: LivenessSettings = Field(default_factory=LivenessSettings, description="When pictures are believed")
    exposure: ExposureSettings = Field(default_factory=ExposureSettings, description="How bright edges may be")
    adjustment: Adjustment = Field(
        default_factory=Adjustment, description="Known error that is taken off, from a verification"
    )
    black_box: BlackBoxSettings = Field(
        default_factory=BlackBoxSettings, description="Pictures kept of what led to an alarm"
    )
    camera_temperature_max_c: float = Field(
        default=75.0,
        ge=0,
        le=120,
        description="Temperature of a camera above which it is too hot",
        json_schema_extra=unit("°C"),
    )

    @property
    @abstractmethod
    def scale_file(self) -> Path | None:
        """File that makes millimetres of pixels; None where the camera brings its own scale."""

    @abstractmethod
    def with_scale_files(self, files: Mapping[str, Path]) -> Self:
        """Copy the settings with other scale files.

        Parameters
        ----------
        files : mapping of str to Path
            By `ScaleFile.setting`, those of the gauge that these settings made.
        """

    def check_adjustment(self, scale_sha256: str) -> None:
        """Refuse a known error that was found with another calibration.

        Parameters
        ----------
        scale_sha256 : str
            SHA-256 of the scale file, hexadecimal; empty without one.

        Raises
        ------
        AdjustmentError
        """
        if why := self.adjustment.refusal(scale_sha256):
            raise AdjustmentError(why, self.scale_fault)

    @abstractmethod
    def make_source(self) -> "PairSource | PictureSource":
        """Make the source of pictures, not opened yet; raises `CameraError` if a library that it needs is missing."""

    @abstractmethod
    def make_range_sensor(self) -> "RangeSensor":
        """Make the laser beside the cameras, not opened yet; one that measures nothing where there is none."""

    @abstractmethod
    def make_gauge(self, on_usable: Callable[[], None], /) -> TimedReader:
        """Make the gauge of these settings.

        Parameters
        ----------
        on_usable : callable
            Called once the settings are known to be usable, before a calibration that takes seconds.

        Raises
        ------
        ScaleError
            The rig or the empty line cannot be used.
        CameraError
            Pictures of a recording cannot be read.
        """

    @abstractmethod
    def with_recording(self, recording: Path, rig: Path | None) -> Self:
        """Copy the settings with a recording in place of the camera.

        Parameters
        ----------
        recording : Path
            Folder with its pictures.
        rig : Path or None
            Rig file of the recording's cameras.

        Raises
        ------
        SettingsError
            The method needs a rig, or has none.
        """

    @abstractmethod
    def check_scale(self) -> ScaleCheck:
        """Check whether the rig or the empty line can be used; raises nothing."""

    @abstractmethod
    def check_pictures(self, pictures: "Sequence[NDArray[np.uint8]]") -> None:
        """Measure pictures of the camera once.

        Parameters
        ----------
        pictures : sequence of ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
            Of one exposure, left first.

        Raises
        ------
        ScaleError
            The pictures do not fit the rig or the empty line.
        CameraError
            Pictures of a recording cannot be read.
        """
