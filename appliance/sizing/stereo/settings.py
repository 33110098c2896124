"""Settings of the sizing station with two calibrated cameras."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self

from pydantic import Field, model_validator

from appliance.cameras.kinds import StereoCamera
from appliance.cameras.recording.settings import RecordingCamera
from appliance.cameras.simulated.settings import MillCamera
from appliance.settings.file import SettingsError
from appliance.settings.section import FilePath, unit
from appliance.sizing.method import ScaleCheck, ScaleError, SizingMethod, TimedReader
from appliance.sizing.range_sensor.settings import NoRange, Range
from vision.edges.names import EdgeMethod
from vision.fusion.names import Fusion

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from appliance.cameras.source import PairSource
    from appliance.sizing.range_sensor.sensor import RangeSensor
    from appliance.sizing.stereo.gauge import LineSetup, RouteV

NO_RIG_SENTENCE = "sizing.rig is not set; make a rig file with `hotgauge calibrate` and set it"
NO_OVALITY_SENTENCE = (
    "sizing.ovality_mm is not set: 0.6 % of the diameter counts in U, and trust may stay low; set what the product "
    "may have"
)


class SizingSettings(SizingMethod):
    """The sizing station with two cameras."""

    scale_fault = "rig_unusable"
    method: Literal["tangent"] = Field(
        default="tangent", description="Two calibrated cameras; the method without this key"
    )

    camera: StereoCamera = Field(default_factory=MillCamera, description="Where image pairs come from")
    rig: FilePath | None = Field(
        default=None,
        description="Calibration of the two cameras, from `hotgauge calibrate`; not needed for the mill",
    )

    edges: EdgeMethod = Field(
        default="forest", description="Edge detector of the virtual boards, the route that stands beside the value"
    )
    edge_model: FilePath | None = Field(
        default=None,
        description="Forest from `hotgauge train-edges` for it; without: the one that comes along. With one of its own "
        "the U of the virtual boards is not known, and they do not judge the value",
    )
    fusion: Fusion = Field(
        default="none",
        description="How the views of the virtual boards are fused; none measures each on its own. Of a fused picture "
        "U is not known, and the virtual boards do not judge the value",
    )

    board_tilt_deg: float = Field(
        default=0.0,
        ge=-10,
        le=10,
        description="How much the line rises along y against the registration boards; `hotgauge measure` fits it",
        json_schema_extra=unit("deg"),
    )
    range: Range = Field(default_factory=NoRange, description="A laser that measures beside the cameras")

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        if self.range.kind == "mill" and self.camera.kind != "mill":
            raise ValueError("range: only the simulated mill has the kind mill; set sizing.range.kind to modbus")
        return self

    @model_validator(mode="after")
    def _check_edge_model(self) -> Self:
        if self.edge_model is not None and self.edges != "forest":
            raise ValueError(f"edge_model: {self.edges} has none; leave it out, or set edges to forest")
        return self

    @property
    def _route_v(self) -> "RouteV":
        from appliance.sizing.stereo.gauge import RouteV

        return RouteV(self.edges, self.edge_model, self.fusion)

    @property
    def scale_file(self) -> Path | None:
        """The rig file; see `SizingMethod.scale_file`."""
        return self.rig

    def with_scale_files(self, files: Mapping[str, Path]) -> Self:
        """Copy the settings with another rig file and another forest; see `SizingMethod.with_scale_files`."""
        ovality_mm = self._own_ovality_mm if self.rig is None else self.ovality_mm
        return self.model_copy(update={"ovality_mm": ovality_mm, **files})

    def make_source(self) -> "PairSource":
        """Make the source of image pairs; see `SizingMethod.make_source`."""
        return self.camera.make_source(self.liveness.apart_max_us)

    def make_range_sensor(self) -> "RangeSensor":
        """The laser of `range`; see `SizingMethod.make_range_sensor`."""
        return self.range.make_sensor()

    def make_gauge(self, on_usable: Callable[[], None], /) -> TimedReader:
        """Make the gauge of the rig file, else of the camera's own rig; see `SizingMethod.make_gauge`."""
        from appliance.sizing.stereo.gauge import pair_gauge, rig_file_gauge
        from appliance.sizing.stereo.rig_file import RigError

        if self.rig is not None:
            return rig_file_gauge(self.rig, self.ovality_mm, self._route_v, self._line)
        calibrate = self.camera.own_rig()
        if calibrate is None:
            raise RigError(NO_RIG_SENTENCE)
        on_usable()
        return pair_gauge(
            calibrate(), f"rig of {self.camera.in_words}", self._own_ovality_mm, self._route_v, self._line
        )

    @property
    def _line(self) -> "LineSetup":
        from appliance.sizing.stereo.gauge import LineSetup, RangeRay

        laser = self.range
        ray = None if laser.kind == "off" else RangeRay(laser.origin_mm, laser.direction, laser.u_mm)
        return LineSetup(self.board_tilt_deg, ray)

    @property
    def _own_ovality_mm(self) -> float:
        """Ovality with the camera's own rig: only the simulated mill has one, and its bars are round."""
        return self.ovality_mm or 0.0

    def with_recording(self, recording: Path, rig: Path | None) -> Self:
        """Copy the settings with a recording and its rig; see `SizingMethod.with_recording`."""
        if rig is None:
            raise SettingsError("--rig: the rig file of these cameras is missing; make it with hotgauge calibrate")
        camera = RecordingCamera(kind="recording", path=recording)
        return self.model_copy(update={"camera": camera, "rig": rig, "range": NoRange()})

    def check_scale(self) -> ScaleCheck:
        """Check whether the rig can be used; see `SizingMethod.check_scale`."""
        from appliance.sizing.stereo.gauge import rig_file_gauge

        if self.rig is None:
            if self.camera.own_rig() is not None:
                return ScaleCheck("rig", "note", f"none; {self.camera.in_words} calibrates itself")
            return ScaleCheck("rig", "BAD", NO_RIG_SENTENCE)
        try:
            rig_file_gauge(self.rig, self.ovality_mm, self._route_v, self._line)
        except ScaleError as error:
            return ScaleCheck("rig", "BAD", str(error))
        if self.ovality_mm is None:
            return ScaleCheck("rig", "note", f"{self.rig}; {NO_OVALITY_SENTENCE}")
        return ScaleCheck("rig", "good", str(self.rig))

    def check_pictures(self, pictures: "Sequence[NDArray[np.uint8]]") -> None:
        """Measure a pair once if a rig file is set; see `SizingMethod.check_pictures`."""
        from appliance.sizing.stereo.gauge import rig_file_gauge

        if self.rig is not None:
            rig_file_gauge(self.rig, self.ovality_mm, self._route_v, self._line).measure(*pictures)
