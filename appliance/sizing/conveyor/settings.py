"""Settings of the sizing station with one camera between barriers."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self

from pydantic import Field, field_validator

from appliance.cameras.kinds import ConveyorCamera
from appliance.cameras.recording.settings import RecordedPictures
from appliance.cameras.simulated.settings import MillThermal
from appliance.settings.file import SettingsError
from appliance.settings.section import FilePath, Section, unit
from appliance.sizing.method import ScaleCheck, SizingMethod, TimedReader

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from appliance.cameras.source import PictureSource
    from appliance.sizing.range_sensor.sensor import RangeSensor


class ConveyorLine(Section):
    """The line under an uncalibrated camera: the distance of two barriers is its scale."""

    barrier_mm: float = Field(
        ge=50, le=10000, description="Distance of the barriers' inner faces", json_schema_extra=unit("mm")
    )
    barrier_height_mm: float = Field(
        default=0.0,
        ge=0,
        le=2000,
        description="Height of the barriers' upper inner edges over the conveyor; 0: not known, and far less exact",
        json_schema_extra=unit("mm"),
    )
    camera_height_mm: float = Field(
        default=0.0,
        ge=0,
        le=50000,
        description="Height of the camera's lens over the conveyor; 0: not known",
        json_schema_extra=unit("mm"),
    )
    barrier_lower_mm: float | None = Field(
        default=None,
        ge=0,
        le=2000,
        description="Height of the barriers' lower edges over the conveyor; 0: walls; not set: as the picture says",
        json_schema_extra=unit("mm"),
    )
    near_columns: list[float] = Field(
        default=[],
        description="Columns of the barriers' inner edges in the middle row; []: found in the picture",
    )
    response_exponent: float | None = Field(
        default=None,
        ge=0.3,
        le=3,
        description="Code values follow light to this power; 1: a linear camera; not set: not known, which widens U",
    )
    compensation_mm: float = Field(
        default=0.0, ge=-50, le=50, description="Added to every diameter", json_schema_extra=unit("mm")
    )
    background: FilePath | None = Field(
        default=None,
        description="Picture of the empty line by this camera; not needed for recordings and the mill",
    )

    @field_validator("near_columns")
    @classmethod
    def _a_pair(cls, columns: list[float]) -> list[float]:
        if columns and not (len(columns) == 2 and columns[0] < columns[1]):
            raise ValueError("two columns are wanted, the left barrier's first")
        return columns


class ConveyorSettings(SizingMethod):
    """The sizing station with one camera over a conveyor between barriers."""

    scale_fault = "empty_line_unusable"
    method: Literal["conveyor"] = Field(description="One camera, not calibrated, over a conveyor between two barriers")
    camera: ConveyorCamera = Field(default_factory=MillThermal, description="Where pictures come from")
    conveyor: ConveyorLine = Field(description="What is known of the line")

    def make_source(self) -> "PictureSource":
        """Make the source of single pictures; see `SizingMethod.make_source`."""
        return self.camera.make_source()

    def make_range_sensor(self) -> "RangeSensor":
        """None: one camera has its scale from the barriers; see `SizingMethod.make_range_sensor`."""
        from appliance.sizing.range_sensor.sensor import NoRangeSensor

        return NoRangeSensor()

    @property
    def scale_file(self) -> Path | None:
        """The picture of the empty line; see `SizingMethod.scale_file`."""
        return self.conveyor.background

    def with_scale_files(self, files: Mapping[str, Path]) -> Self:
        """Copy the settings with another picture of the empty line; see `SizingMethod.with_scale_files`."""
        return self.model_copy(update={"conveyor": self.conveyor.model_copy(update=dict(files))})

    def make_gauge(self, _on_usable: Callable[[], None], /) -> TimedReader:
        """Make the gauge from the empty line; see `SizingMethod.make_gauge`."""
        from appliance.sizing.conveyor.gauge import conveyor_gauge

        return conveyor_gauge(self)

    def with_recording(self, recording: Path, rig: Path | None) -> Self:
        """Copy the settings with a recording; see `SizingMethod.with_recording`."""
        if rig is not None:
            raise SettingsError('--rig: sizing.method = "conveyor" has none; leave it out')
        return self.model_copy(update={"camera": RecordedPictures(kind="recording", path=recording)})

    def check_scale(self) -> ScaleCheck:
        """Check that the empty line shows two straight barriers; see `SizingMethod.check_scale`."""
        from appliance.cameras.source import CameraError
        from appliance.sizing.conveyor.empty_line import EmptyLineError
        from appliance.sizing.conveyor.gauge import conveyor_gauge

        try:
            gauge = conveyor_gauge(self)
        except (CameraError, EmptyLineError) as error:
            return ScaleCheck("barriers", "BAD", str(error))
        return ScaleCheck("barriers", "good", f"two straight ones in {gauge.name}")

    def check_pictures(self, pictures: "Sequence[NDArray[np.uint8]]") -> None:
        """Measure a picture once; see `SizingMethod.check_pictures`."""
        from appliance.sizing.conveyor.gauge import conveyor_gauge

        conveyor_gauge(self).measure(*pictures)
