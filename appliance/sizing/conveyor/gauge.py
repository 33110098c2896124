"""What the sizing station measures with between two barriers: its empty line and its gauge."""

from functools import partial

from appliance.cameras.section import EmptyLine
from appliance.sizing.conveyor.empty_line import EmptyLineError, TimedConveyorGauge, background
from appliance.sizing.conveyor.settings import ConveyorLine, ConveyorSettings
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge


def conveyor_gauge(settings: ConveyorSettings) -> TimedConveyorGauge:
    """The gauge of a line whose barriers show.

    Raises
    ------
    EmptyLineError
        There is no picture of the empty line or it cannot be read, its barriers are hidden or bent, or the lengths
        contradict each other.
    CameraError
        The empty line is one of a recording's pictures, and these cannot be read.
    """
    empty = _empty(settings)
    make = partial(
        ConveyorGauge,
        reference=_reference(settings.conveyor),
        compensation_mm=settings.conveyor.compensation_mm,
        ovality_mm=settings.ovality_mm,
        near_columns=(columns[0], columns[1]) if (columns := settings.conveyor.near_columns) else None,
        response_exponent=settings.conveyor.response_exponent,
    )
    gauge = TimedConveyorGauge(empty.pictures, empty.name, make)
    gauge.check_barriers()
    return gauge


def _empty(settings: ConveyorSettings) -> EmptyLine:
    """The empty line from its file, else the one that the camera has by itself."""
    file = settings.conveyor.background
    empty = settings.camera.own_empty_line() if file is None else EmptyLine(background(file), str(file))
    if empty is None:
        raise EmptyLineError("sizing.conveyor.background is not set; set it to a picture of the line without a bar")
    return empty


def _reference(line: ConveyorLine) -> ConveyorReference:
    try:
        return ConveyorReference(
            line.barrier_mm, line.barrier_height_mm or None, line.camera_height_mm or None, line.barrier_lower_mm
        )
    except ValueError as error:
        raise EmptyLineError(f"sizing.conveyor: {error}") from error
