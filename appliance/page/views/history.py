"""The view of the history: bars and ingots of a time, the profile along a bar, exports and the shift report."""

from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, NamedTuple

from markupsafe import Markup

from appliance.history.export import write_csv
from appliance.history.read import History, moment, open_to_read
from appliance.history.schema import HistoryError
from appliance.history.tables import ALARMS, BARS, INGOTS, READINGS, TABLES, Value
from appliance.page.drawing import Frame, Point, chart
from appliance.page.texts import Texts
from appliance.page.views.line import limits_of
from plc.codes import Decision

ROWS_MAX = 200  # chosen: newest first; more are exported
SPAN = timedelta(hours=8)  # without a choice: a shift
SPAN_MAX = timedelta(days=31)
PROFILE_GAP_S = 3.0  # chosen: longer than the longest `history.reading_period_s` that shows a profile
SHIFT_HOURS = 8.0
EXPORTS = {table.name: table for table in TABLES}

Row = dict[str, Value]


class Period(NamedTuple):
    """A time, and which of its bars are shown.

    Attributes
    ----------
    start, end : datetime
        With a time zone.
    decision : str
        Number of a decision; empty for all.
    product : str
        Number of a product; empty for all.
    """

    start: datetime
    end: datetime
    decision: str = ""
    product: str = ""

    @classmethod
    def of(cls, query: Mapping[str, str]) -> "Period":
        """What a form has asked for; what it lacks, or is no moment, gives the last shift."""
        now = datetime.now(UTC).astimezone()
        end = _moment(query.get("to", ""), now)
        start = max(_moment(query.get("from", ""), end - SPAN), end - SPAN_MAX)
        if not start < end:
            start = end - SPAN
        return cls(start, end, query.get("decision", "")[:1], query.get("product", "")[:10])

    def shows(self, row: Row) -> bool:
        """Whether a bar is wanted."""
        return self.decision in {"", str(row["decision"])} and self.product in {"", str(row["product_id"])}


def _moment(text: str, otherwise: datetime) -> datetime:
    try:
        return moment(text)
    except (ValueError, OverflowError, OSError):
        return otherwise


def values(folder: Path | None, texts: Texts, query: Mapping[str, str]) -> dict[str, Any]:
    """What the view shows of a time.

    Parameters
    ----------
    folder : Path or None
        Of the history.
    texts : Texts
    query : mapping of str to str
        `from`, `to`, `decision`, `product`; `bar` is the start of one, ms since 1970 UTC.
    """
    period = Period.of(query)
    shown: dict[str, Any] = {
        "period": period,
        "trouble": "" if folder is not None else texts("history_off"),
        "decisions": [(str(int(decision)), texts(f"decision_{int(decision)}")) for decision in Decision],
        "exports": EXPORTS,
        "bars": [],
        "ingots": [],
        "alarms": [],
        "profile": None,
    }
    if folder is None:
        return shown
    try:
        with open_to_read(folder) as history:
            bars = [bar for bar in history.rows(BARS, period.start, period.end) if period.shows(bar)]
            shown["bars"] = [_bar(bar, texts) for bar in bars[: -ROWS_MAX - 1 : -1]]
            shown["ingots"] = [_ingot(row, texts) for row in _newest(history, INGOTS, period)]
            shown["alarms"] = [_alarm(row, texts) for row in _newest(history, ALARMS, period)]
            shown["profile"] = _profile(history, bars, query.get("bar", ""), texts)
    except HistoryError as error:
        shown["trouble"] = str(error)
    return shown


def _newest(history: History, table: Any, period: Period) -> list[Row]:
    return list(history.rows(table, period.start, period.end))[: -ROWS_MAX - 1 : -1]


def _clock(utc_ms: Value) -> str:
    if utc_ms is None:
        return "–"
    return datetime.fromtimestamp(float(utc_ms) / 1000, UTC).astimezone().strftime("%Y-%m-%d %H:%M:%S")


def _bar(row: Row, texts: Texts) -> dict[str, Any]:
    return {
        "key": row["started_utc_ms"],
        "started": _clock(row["started_utc_ms"]),
        "number": row["bar"],
        "product": row["product_id"] or "–",
        "target": _number(row["target_mm"], texts),
        "decision": int(row["decision"] or 0),
        **{name: _number(row[f"{name}_mm"], texts) for name in ("head", "mean", "tail", "smallest", "largest")},
        "expanded": _number(row["expanded_uncertainty_mm"], texts),
    }


def _ingot(row: Row, texts: Texts) -> dict[str, Any]:
    return {
        "told": _clock(row["told_utc_ms"]),
        "number": row["ingot"],
        "end": texts(f"ingot_{row['orientation']}"),
        "confidence": _number(row["confidence"], texts),
    }


def _alarm(row: Row, texts: Texts) -> dict[str, Any]:
    names = ("came", "acknowledged", "gone")
    times = {name: _clock(row[f"{name}_utc_ms"]) for name in names}
    return {"text": texts.alarm(str(row["name"]))[0], **times}


def _number(value: Value, texts: Texts) -> str:
    return texts.number(None if value is None else float(value))


def _profile(history: History, bars: list[Row], key: str, texts: Texts) -> dict[str, Any] | None:
    """Readings along one bar as they were kept."""
    bar = next((bar for bar in bars if str(bar["started_utc_ms"]) == key), None)
    if bar is None:
        return None
    start_s, end_s = float(bar["started_utc_ms"] or 0) / 1000, float(bar["ended_utc_ms"] or 0) / 1000
    span = datetime.fromtimestamp(start_s, UTC), datetime.fromtimestamp(end_s + 0.001, UTC)
    cold = bar["grade"] is not None
    names = ("diameter_cold_mm", "expanded_uncertainty_cold_mm") if cold else ("diameter_mm", "expanded_uncertainty_mm")
    readings = [row for row in history.rows(READINGS, *span) if row["valid"]]
    points = [
        Point(float(row["exposed_utc_ms"] or 0) / 1000 - start_s, _float(row[names[0]]), _float(row[names[1]]))
        for row in readings
    ]
    length_s = max(end_s - start_s, 0.1)
    ticks = [(length_s * share / 5, f"{texts.number(length_s * share / 5, 1)} s") for share in range(6)]
    limits = limits_of(*(_float(bar[f"{name}_mm"]) for name in ("target", "tolerance_plus", "tolerance_minus")))
    frame = Frame(0.0, length_s, PROFILE_GAP_S, ticks, texts("profile"), texts.decimal)
    drawn = Markup(chart(points, limits, frame))  # noqa: S704  it escapes its words
    return {"number": bar["bar"], "chart": drawn, "readings": len(readings)}


def _float(value: Value) -> float | None:
    return None if value is None else float(value)


def export(folder: Path, name: str, period: Period, output: Path) -> None:
    """Write a table of a time as CSV.

    Parameters
    ----------
    folder : Path
    name : str
        Table of the history.
    period : Period
    output : Path

    Raises
    ------
    HistoryError
    """
    with open_to_read(folder) as history:
        write_csv(EXPORTS[name], history.rows(EXPORTS[name], period.start, period.end), output)


def report(folder: Path, period: Period, output: Path) -> None:
    """Write the report of the shifts of a time as HTML.

    Parameters
    ----------
    folder : Path
    period : Period
    output : Path

    Raises
    ------
    HistoryError
    ReportMissingError
    """
    from appliance.reports.shift import shifts  # noqa: PLC0415  loads what only reports need
    from appliance.reports.write import write_report  # noqa: PLC0415

    with open_to_read(folder) as history:
        write_report(shifts(history, period.start, period.end, SHIFT_HOURS), output)
