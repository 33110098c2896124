"""Writes the report of a time, as HTML that stands alone or as PDF: an overview, and a page for each shift."""

import importlib.resources
from collections.abc import Iterable, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from appliance.reports import charts
from appliance.reports.control_chart import SUBGROUPS_ENOUGH
from appliance.reports.pages import data_address, library, render, write_pages
from appliance.reports.shift import Shift
from plc.codes import Decision

BARS_SHOWN = 4
LASTING_SHOWN = 3
SERIES_SHOWN = 3


def write_report(all_shifts: Iterable[Shift], output: Path) -> int:
    """Write the report; how many shifts it has. Raises `OSError`.

    Parameters
    ----------
    all_shifts : iterable of Shift
    output : Path
        PDF if its suffix is `.pdf`, else HTML.

    Raises
    ------
    ReportMissingError
    """
    for name in ("jinja2", "matplotlib"):
        library(name, output)  # before the history is read
    done = list(all_shifts)
    text = importlib.resources.files("appliance.reports").joinpath("report.html").read_text(encoding="utf-8")
    names = {"shifts": done, "limits": _LIMITS, "decision": Decision, "enough": SUBGROUPS_ENOUGH}
    pictures = {"trend": _trend, "control": _control, "span": _span}
    write_pages(render(text, output, {**names, **pictures}, _FILTERS), output)
    return len(done)


_LIMITS = {"bars": BARS_SHOWN, "lasting": LASTING_SHOWN, "series": SERIES_SHOWN}


def _trend(shift: Shift) -> str:
    return data_address(charts.trend(shift))


def _control(shift: Shift) -> str:
    return "" if shift.chart is None else data_address(charts.control(shift.chart))


def _span(all_shifts: Sequence[Shift]) -> str:
    return f"{_moment(all_shifts[0].start)} to {_moment(all_shifts[-1].end)}"


def _moment(when: datetime | float) -> str:
    return _local(when).strftime("%Y-%m-%d %H:%M %Z")


def _clock(when: datetime | float) -> str:
    return _local(when).strftime("%H:%M:%S")


def _local(when: datetime | float) -> datetime:
    return when if isinstance(when, datetime) else datetime.fromtimestamp(when / 1000).astimezone()


def _duration(seconds: float) -> str:
    hours, rest = divmod(round(seconds), 3600)
    minutes, rest_s = divmod(rest, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {rest_s:02} s" if minutes else f"{seconds:.1f} s"


def _index(index: Any) -> str:
    return f"{index.value:.2f} ({index.low:.2f}–{index.high:.2f})"


_FILTERS = {"moment": _moment, "clock": _clock, "duration": _duration, "index": _index}
