"""What the sizing station measures with between two barriers: its single camera, its empty line, its gauge."""

from functools import partial

from appliance.cameras.oak.settings import OakPictures
from appliance.cameras.recording.pictures import PictureRecording, PictureRecordingSource
from appliance.cameras.recording.settings import RecordedPictures
from appliance.cameras.simulated.settings import MillThermal
from appliance.cameras.simulated.thermal import ThermalMillSource
from appliance.cameras.source import PairSource, PictureSource
from appliance.cameras.stream.settings import StreamPictures
from appliance.cameras.stream.source import StreamPictureSource
from appliance.processes.station_process import oak
from appliance.sizing.conveyor.empty_line import EmptyLineError, Picture, TimedConveyorGauge, background, darkest
from appliance.sizing.conveyor.settings import ConveyorLine, ConveyorSettings
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge


def conveyor_source(camera: MillThermal | RecordedPictures | OakPictures | StreamPictures) -> PictureSource:
    """The source of pictures that the settings name, not opened yet."""
    match camera:
        case RecordedPictures():
            return PictureRecordingSource(camera.path, rate_hz=camera.rate_hz, loop=camera.loop)
        case StreamPictures():
            return StreamPictureSource(camera)
        case OakPictures():
            return oak().OakPictureSource(camera)
        case MillThermal():
            return ThermalMillSource(camera.seed, camera.rate_hz)


def conveyor_gauge(settings: ConveyorSettings, source: PairSource | PictureSource) -> TimedConveyorGauge:
    """The gauge of a line whose barriers show.

    Raises
    ------
    EmptyLineError
        There is no picture of the empty line or it cannot be read, its barriers are hidden or bent, or the lengths
        contradict each other.
    CameraError
        The empty line is one of a recording's pictures, and these cannot be read.
    """
    empty, name = _empty(settings, source)
    make = partial(
        ConveyorGauge,
        reference=_reference(settings.conveyor),
        compensation_mm=settings.conveyor.compensation_mm,
        ovality_mm=settings.ovality_mm,
    )
    gauge = TimedConveyorGauge(empty, name, make)
    gauge.check_barriers()
    return gauge


def _empty(settings: ConveyorSettings, source: PairSource | PictureSource) -> tuple[list[Picture], str]:
    """Pictures of the empty line, and where they come from."""
    if settings.conveyor.background is not None:
        return background(settings.conveyor.background), str(settings.conveyor.background)
    if isinstance(settings.camera, RecordedPictures):
        return darkest(PictureRecording(settings.camera.path)), f"the darkest pictures of {settings.camera.path}"
    if isinstance(source, ThermalMillSource):
        return source.empty(), "the simulated line"
    raise EmptyLineError("sizing.conveyor.background is not set; set it to a picture of the line without a bar")


def _reference(line: ConveyorLine) -> ConveyorReference:
    try:
        return ConveyorReference(line.barrier_mm, line.barrier_height_mm or None, line.camera_height_mm or None)
    except ValueError as error:
        raise EmptyLineError(f"sizing.conveyor: {error}") from error
