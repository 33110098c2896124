"""Writes the report of a time, as HTML that stands alone or as PDF: an overview, and a page for each shift."""

import base64
import importlib
import importlib.resources
from collections.abc import Iterable, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from appliance.errors import HotgaugeError
from appliance.files.atomic_file import whole_place
from appliance.reports import charts
from appliance.reports.control_chart import SUBGROUPS_ENOUGH
from appliance.reports.shift import Shift
from plc.codes import Decision

BARS_SHOWN = 4
LASTING_SHOWN = 3
SERIES_SHOWN = 3


class ReportMissingError(HotgaugeError):
    """A library that makes reports is not installed; the message says what to do."""


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
    try:
        jinja: Any = importlib.import_module("jinja2")
        importlib.import_module("matplotlib")
        weasyprint: Any = importlib.import_module("weasyprint") if output.suffix.lower() == ".pdf" else None
    except (ImportError, OSError) as error:  # OSError: the library is there, and Debian's Pango is not
        words = "reports need more libraries; pip install 'hotgauge[report]' and apt-get install libpangoft2-1.0-0"
        raise ReportMissingError(f"{output}: {words} ({error})") from error
    done = list(all_shifts)
    html = _template(jinja).render(shifts=done, limits=_LIMITS, decision=Decision, enough=SUBGROUPS_ENOUGH)
    with whole_place(output) as place:
        if weasyprint is None:
            place.write_text(html, encoding="utf-8")
        else:
            weasyprint.HTML(string=html).write_pdf(place)
    return len(done)


_LIMITS = {"bars": BARS_SHOWN, "lasting": LASTING_SHOWN, "series": SERIES_SHOWN}


def _template(jinja: Any) -> Any:
    environment: Any = jinja.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"moment": _moment, "clock": _clock, "duration": _duration, "index": _index}
    environment.globals |= {"trend": _trend, "control": _control, "span": _span}
    text = importlib.resources.files("appliance.reports").joinpath("report.html").read_text(encoding="utf-8")
    return environment.from_string(text)


def _trend(shift: Shift) -> str:
    return _picture(charts.trend(shift))


def _control(shift: Shift) -> str:
    return "" if shift.chart is None else _picture(charts.control(shift.chart))


def _picture(svg: str) -> str:
    return svg and "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()


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
