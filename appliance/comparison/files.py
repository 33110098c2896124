"""Reads what `measure` and `orient` wrote, and the truth of a recording."""

import csv
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple, cast

from appliance.errors import HotgaugeError, reading_advice

SIZE_TRUTH, END_TRUTH = "truth.json", "truth.csv"
_END_COLUMNS = frozenset({"frame", "present", "label", "state"})
_WHOLE_NUMBERS = frozenset({"frame", "ingot", "first_frame", "decided_frame"})
_NUMBERS = _WHOLE_NUMBERS | {"diameter_mm", "expanded_uncertainty_mm", "diameter_virtual_board_mm", "ssim_top"}
_FLAGS = frozenset({"present", "valid"})
_VERDICTS = frozenset({"top", "bottom", "undecided"})
_LABELS = frozenset({"top", "bottom", ""})
_NOT_BELOW = 2**53  # of a number: frames that are named by their microseconds stay below


class ComparisonError(HotgaugeError):
    """Readings and truth cannot be compared; the message says what, where and what to do."""


class EndTruth(NamedTuple):
    """What is true of a picture of the ingot line.

    Attributes
    ----------
    present : bool
        The whole end of an ingot on the line is in view.
    label : str
        top, bottom, or nothing.
    state : str
        empty, hanging, lowering, placed or leaving.
    """

    present: bool
    label: str
    state: str


SizeTruth = dict[int, float | None]  # frame to diameter, mm; None: no bar that can be measured
Rows = list[dict[str, Any]]


def read_rows(path: Path, *, least: int = 1) -> Rows:
    """Rows of a file that `measure` or `orient` wrote: CSV if its suffix is `.csv`, else JSON lines.

    Fields of CSV become numbers, bool, or None where they are empty; reasons stay text.

    Parameters
    ----------
    path : Path
    least : int
        Rows that it must hold.

    Raises
    ------
    ComparisonError
        The file cannot be read, or holds no rows.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            if path.suffix.lower() == ".csv":
                rows: Rows = [{name: _value(text) for name, text in row.items()} for row in csv.DictReader(file)]
            else:
                rows = [json.loads(line) for line in file if line.strip()]
        for number, row in enumerate(rows, 1):
            _check_row(row, f"row {number}")
    except OSError as error:
        raise ComparisonError(
            f"{path}: cannot be read ({error.strerror}); {reading_advice(error, 'give what measure or orient wrote')}"
        ) from error
    except (ValueError, RecursionError, csv.Error) as error:
        raise ComparisonError(
            f"{path}: is neither CSV nor JSON lines of readings ({error}); give what measure or orient wrote"
        ) from error
    if len(rows) < least:
        raise ComparisonError(f"{path}: holds no readings; give what hotgauge measure or hotgauge orient wrote")
    return rows


def _check_row(row: object, where: str) -> None:
    """Raise `ValueError` for a row that is no reading."""
    if not isinstance(row, dict):
        raise ValueError(f"{where} is no object")  # noqa: TRY004  it is bad data, not a wrong call
    values = cast("dict[str, object]", row)
    for name, value in values.items():
        if value is not None and not _is_possible(name, value):
            raise ValueError(f"{where}: {name} is {value!r:.40}")
    needed = ("present", "orientation") if "ssim_top" in values else ()
    needed = ("first_frame", "orientation") if values.get("ingot") is not None else needed
    needed = (*needed, "ssim_top") if values.get("present") else needed
    for name in needed:
        if values.get(name) is None:
            raise ValueError(f"{where}: {name} is missing")


def _is_possible(name: str, value: object) -> bool:
    if name in _FLAGS:
        return isinstance(value, bool)
    if name == "orientation":
        return value in _VERDICTS
    if name in _NUMBERS:
        is_number = type(value) is int or (type(value) is float and name not in _WHOLE_NUMBERS)
        return is_number and abs(cast("float", value)) < _NOT_BELOW
    return True


def _value(text: str | list[str] | None) -> float | int | bool | str | None:
    if not isinstance(text, str) or not text:  # a list: of cells without a heading
        return None
    if text in {"true", "false"}:
        return text == "true"
    try:
        number = float(text)
    except ValueError:
        return text
    return int(number) if number.is_integer() and "." not in text else number


def read_truth(path: Path) -> SizeTruth | dict[int, EndTruth]:
    """Truth of a recording: `truth.json` of bars, `truth.csv` of ingots, or the folder that holds one.

    Raises
    ------
    ComparisonError
        There is no such file, or it holds no truth.
    """
    try:
        if path.is_dir():
            there = [path / name for name in (SIZE_TRUTH, END_TRUTH) if (path / name).is_file()]
            if not there:
                raise ComparisonError(f"{path}: has neither {SIZE_TRUTH} nor {END_TRUTH}; give a recording with truth")
            path = there[0]
        text = path.read_text(encoding="utf-8-sig")
        return _end_truth(text) if path.suffix.lower() == ".csv" else _size_truth(json.loads(text))
    except OSError as error:
        raise ComparisonError(
            f"{path}: cannot be read ({error.strerror}); {reading_advice(error, 'give the truth of a recording')}"
        ) from error
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError, csv.Error) as error:
        raise ComparisonError(
            f"{path}: is no truth ({error}); give truth.json with frames and diameter_mm, or truth.csv of ingots"
        ) from error


def _size_truth(document: Mapping[str, Any]) -> SizeTruth:
    shared = document.get("diameter_mm")
    truth: SizeTruth = {}
    for row in document["frames"]:
        diameter_mm = None if row.get("empty") else row.get("diameter_mm", shared)
        if diameter_mm is not None and not (math.isfinite(diameter_mm) and diameter_mm > 0):
            raise ValueError(f"frame {row['frame']} has the diameter {diameter_mm}")
        truth[int(row["frame"])] = diameter_mm
    return truth


def _end_truth(text: str) -> dict[int, EndTruth]:
    reader = csv.DictReader(text.splitlines())
    missing = _END_COLUMNS - set(reader.fieldnames or ())
    if missing:
        raise ValueError(f"the column {min(missing)} is missing")
    truth = {int(row["frame"]): EndTruth(row["present"] == "1", row["label"], row["state"]) for row in reader}
    for frame, one in truth.items():
        if one.label not in _LABELS:
            raise ValueError(f"frame {frame} has the label {one.label!r:.40}")
    return truth
