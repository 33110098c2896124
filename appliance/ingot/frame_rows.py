"""Rows of the file that `orient` writes: one for each picture, one for each ingot."""

from appliance.files.columns import FileColumn
from appliance.files.row_writer import Row
from vision.ingot.sequential_decision import IngotDecision
from vision.readings import OrientationReading

FRAME_COLUMNS = (
    FileColumn("frame", "", None, "number of the frame"),
    FileColumn("present", "", None, "whether an ingot's end lies on the line"),
    FileColumn("orientation", "", None, "verdict of this frame alone: `top`, `bottom` or `undecided`"),
    FileColumn("ssim_top", "", 4, "similarity to the reference of the top, -1 to 1"),
    FileColumn("ssim_bottom", "", 4, "similarity to the reference of the bottom, -1 to 1"),
    FileColumn("center_x", "px", 2, "column of the end's centre in the whole picture"),
    FileColumn("center_y", "px", 2, "row of the end's centre in the whole picture"),
    FileColumn("radius", "px", 2, "radius of the end"),
    FileColumn("reasons", "", None, "flags of [reasons of ingots](reasons.md#reason-flags-of-ingots)"),
)
INGOT_COLUMNS = (
    FileColumn("ingot", "", None, "number of the ingot in this recording, from 1"),
    FileColumn("orientation", "", None, "verdict on the ingot: `top`, `bottom` or `undecided`"),
    FileColumn("first_frame", "", None, "first frame that shows its end"),
    FileColumn("decided_frame", "", None, "frame of the verdict; empty for an ingot that stayed undecided"),
    FileColumn("confidence", "%", 3, "probability of the verdict by the classifier's own statistics"),
)


def frame_row(frame: int, reading: OrientationReading) -> Row:
    """Row of one reading; None for no value.

    Parameters
    ----------
    frame : int
        Number of the frame.
    reading : OrientationReading
    """
    values = {"frame": frame, "reasons": reading.reasons.names}
    found = {column.name: values.get(column.name, getattr(reading, column.name, None)) for column in FRAME_COLUMNS}
    return {column.name: column.written(found[column.name]) for column in FRAME_COLUMNS}


def ingot_row(decision: IngotDecision) -> Row:
    """Row of one ingot."""
    return {column.name: column.written(getattr(decision, column.name)) for column in INGOT_COLUMNS}
