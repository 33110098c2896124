"""What studies found, and how their figures are written."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

FOLDER = Path(__file__).parent

Summary = dict[str, Any]
Rows = list[tuple[str, ...]]
Numbers = tuple[str, ...]


class Sentence(NamedTuple):
    """What a document says, and the numbers in it."""

    document: str
    numbers: Callable[[], Numbers]
    text: str


def result(name: str) -> Summary:
    """A study's result file."""
    return json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))


def summary(name: str) -> Summary:
    """What a study's result file sums up."""
    return result(name)["summary"]


def percent(share: float, digits: int = 0) -> str:
    """A share in percent."""
    return f"{100 * share:.{digits}f} %"


def length(value_mm: float | None, form: str = ".2f") -> str:
    """A length, or a dash where there is none."""
    return "-" if value_mm is None else format(value_mm, form)


def lengths(values: Summary, *names: str, form: str = ".2f") -> str:
    """Some lengths of a summary, by commas."""
    return ", ".join(length(values[name], form) for name in names)
