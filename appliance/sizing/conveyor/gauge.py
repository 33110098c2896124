"""Makes the conveyor gauge from the settings and the picture of the empty line."""

from functools import partial

from appliance.cameras.section import EmptyLine
from appliance.sizing.conveyor.empty_line import EmptyLineError, TimedConveyorGauge, read_background
from appliance.sizing.conveyor.settings import ConveyorLine, ConveyorSettings
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge


def conveyor_gauge(settings: ConveyorSettings) -> TimedConveyorGauge:
    """Make the gauge of a line with two straight, visible barriers.

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
        ovality_mm=settings.ovality_mm or 0.0,
        near_columns=(columns[0], columns[1]) if (columns := settings.conveyor.near_columns) else None,
        response_exponent=settings.conveyor.response_exponent,
    )
    gauge = TimedConveyorGauge(empty, make)
    gauge.check_barriers()
    return gauge


def _empty(settings: ConveyorSettings) -> EmptyLine:
    """Empty line from the file of the settings, else the camera's own (recordings and the mill have one)."""
    file = settings.conveyor.background
    empty = settings.camera.own_empty_line() if file is None else read_background(file)
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
