"""`hotgauge compare`: readings of a recording against its truth, as a table and a plot."""

from collections import Counter
from pathlib import Path
from typing import Any, TypeVar

from appliance.comparison.ends import compared_ends, end_lines
from appliance.comparison.files import ComparisonError, EndTruth, read_rows, read_truth
from appliance.comparison.plots import plot_ends, plot_sizes
from appliance.comparison.sizes import Sizes, compared, size_lines
from appliance.ingot.orient_recording import ingots_file

TruthT = TypeVar("TruthT")


def compare(readings: Path, truth: Path, plot: Path | None = None) -> list[str]:
    """Table of a comparison.

    Parameters
    ----------
    readings : Path
        What `measure` or `orient` wrote; of CSV, the file of ingots beside it belongs to it.
    truth : Path
        See `read_truth`.
    plot : Path or None
        Picture to write.

    Raises
    ------
    ComparisonError
        A file cannot be read, readings and truth are not of one kind, they share no frame, or bars lie side by side.
    PlotsMissingError
        `plot` is given and Matplotlib is not installed.
    OSError
        The plot cannot be written.
    """
    rows, known = read_rows(readings), read_truth(truth)
    of_ends = any("ssim_top" in row for row in rows)
    if of_ends and readings.suffix.lower() == ".csv" and ingots_file(readings).is_file():
        rows += read_rows(ingots_file(readings), least=0)
    if not any(row.get("frame") in known for row in rows):
        raise ComparisonError(f"{truth}: shares no frame with {readings}; give the truth of the same recording")
    ends = {frame: one for frame, one in known.items() if isinstance(one, EndTruth)}
    if of_ends != bool(ends):
        kinds = ("ingots", "bars") if of_ends else ("bars", "ingots")
        raise ComparisonError(f"{readings} are readings of {kinds[0]}, {truth} is of {kinds[1]}; give two of a kind")
    return _ends(rows, ends, plot) if of_ends else _sizes(rows, known, plot)


def _ends(rows: list[dict[str, Any]], truth: dict[int, EndTruth], plot: Path | None) -> list[str]:
    if plot is not None:
        plot_ends(rows, truth, plot)
    return end_lines(compared_ends(rows, truth))


def _sizes(rows: list[dict[str, Any]], known: Any, plot: Path | None) -> list[str]:
    times = Counter(row.get("frame") for row in rows)
    if side_by_side := [frame for frame in known if times[frame] > 1]:
        raise ComparisonError(
            f"frame {side_by_side[0]} has readings of {times[side_by_side[0]]} bars and the truth one diameter; "
            "compare a recording of one bar at a time"
        )
    sizes = Sizes.of(rows, known)
    if plot is not None:
        plot_sizes(sizes, plot)
    return size_lines(compared(sizes))
