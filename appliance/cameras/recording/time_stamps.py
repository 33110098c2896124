"""Time stamps of a recording of two cameras: `timestamps.csv`.

Columns: `frame`, `left_us` and `right_us` (µs), and `stamped`: 1 where both stamps are of one clock that the cameras
share and so prove how far apart the exposures were, 0 where this computer estimated them. Without that column they are
the cameras' own. `range_mm`, where there is such a column, is what a laser beside the cameras measured at that moment.
"""

import csv
import io
import itertools
import math
import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, Self

from appliance.cameras.source import CameraError, FramePair

STAMPS_FILE = "timestamps.csv"
FRAME_PERIOD_S = 0.04  # of a recording without time stamps: 25 frames a second
COLUMNS = ("frame", "left_us", "right_us", "stamped")
RANGE_COLUMN = "range_mm"


class Stamps(NamedTuple):
    """Time stamps of one pair.

    Attributes
    ----------
    left_us, right_us : int
        Device time stamps of the left and the right exposure, µs.
    stamped : bool
    range_mm : float
        As in `FramePair`.
    """

    left_us: int
    right_us: int
    stamped: bool
    range_mm: float = math.nan

    @classmethod
    def of(cls, pair: FramePair) -> Self:
        """Those of a pair, without its pictures."""
        return cls(pair.left_us, pair.right_us, pair.stamped, pair.range_mm)


def read_stamps(folder: Path) -> dict[int, Stamps]:
    """Time stamps by frame of a recording; none without a `timestamps.csv`.

    Raises
    ------
    CameraError
        The file is no table of whole numbers, or one is too large.
    """
    path = folder / STAMPS_FILE
    if not path.is_file():
        return {}
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.DictReader(file))
        return {int(row["frame"]): _stamps(row) for row in rows}
    except (OSError, ValueError, KeyError, TypeError, csv.Error) as error:
        raise CameraError(
            f"{path}: not a table of whole numbers with the columns frame,left_us,right_us ({error!r}); "
            "correct the file or remove it"
        ) from error


def _stamps(row: dict[str, str]) -> Stamps:
    return Stamps(
        int(row["left_us"]),
        int(row["right_us"]),
        bool(int(row.get("stamped", 1))),
        float(row.get(RANGE_COLUMN) or math.nan),
    )


def stamps_table(stamps: Mapping[int, Stamps]) -> bytes:
    """Content of a `timestamps.csv`, by frame; with ranges, to the last digit, where a laser measured any."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    with_ranges = any(math.isfinite(one.range_mm) for one in stamps.values())
    table.writerow((*COLUMNS, RANGE_COLUMN) if with_ranges else COLUMNS)
    for number, one in stamps.items():
        range_mm = repr(one.range_mm) if math.isfinite(one.range_mm) else ""
        row = (number, one.left_us, one.right_us, int(one.stamped))
        table.writerow((*row, range_mm) if with_ranges else row)
    return text.getvalue().encode()


class FrameMoments:
    """Moments of a recording's frames: their time stamps, else their numbers at `FRAME_PERIOD_S` for the usual step.

    The usual step is the median, so numbers may count every tenth frame or be microseconds of a date. A frame without a
    time stamp among others that have one follows the frame before.

    Parameters
    ----------
    numbers : sequence of int
        Frame numbers of the recording.
    stamps : mapping of int to Stamps, optional
        Time stamps by frame.
    """

    def __init__(self, numbers: Sequence[int], stamps: Mapping[int, Stamps] | None = None) -> None:
        steps = [later - earlier for earlier, later in itertools.pairwise(numbers)]
        self._usual_step = statistics.median(steps) if steps else 1
        self._stamps = stamps or {}
        self._number = numbers[0] if numbers else 0
        self._moment_s = 0.0

    def moment_s(self, number: int) -> float:
        """Moment of the left exposure, on a clock of the recording.

        Parameters
        ----------
        number : int
            Number of the frame; not smaller than those before.
        """
        if number in self._stamps:
            self._moment_s = self._stamps[number].left_us / 1e6
        else:
            self._moment_s += (number - self._number) / self._usual_step * FRAME_PERIOD_S
        self._number = number
        return self._moment_s
