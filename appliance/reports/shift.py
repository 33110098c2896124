"""What the history says of one shift, in figures."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, NamedTuple

from appliance.diagnostics.alarms import ALARMS
from appliance.diagnostics.fault_table import FAULTS
from appliance.history.read import History, to_ms
from appliance.history.tables import ALARMS as ALARM_ROWS
from appliance.history.tables import BARS, CALIBRATIONS, INGOTS, RUNS
from appliance.history.tables import FAULTS as FAULT_ROWS
from appliance.reports.capability import Capability, capability
from appliance.reports.control_chart import ControlChart, control_chart, subgroups
from appliance.reports.intervals import Interval, length_ms, without
from plc.codes import Decision, DeviceState

Bar = dict[str, Any]  # a row of the table of bars


class Lasting(NamedTuple):
    """One alarm or fault over a shift.

    Attributes
    ----------
    name : str
    text : str
        What the operator reads.
    times : int
        How often it was there.
    total_s, longest_s : float
        Time of the shift in which it was there, and the longest stretch of it.
    """

    name: str
    text: str
    times: int
    total_s: float
    longest_s: float


class Series(NamedTuple):
    """Bars of one target and tolerance.

    Attributes
    ----------
    target_mm, plus_mm, minus_mm : float
    cold : bool
        Whether these are sizes at 20 °C.
    bars : list of Bar
        In the order of time.
    capability : Capability or None
        None for too few bars.
    """

    target_mm: float
    plus_mm: float
    minus_mm: float
    cold: bool
    bars: list[Bar]
    capability: Capability | None


@dataclass(frozen=True, slots=True)
class Shift:
    """One shift.

    Attributes
    ----------
    start, end : datetime
        In local time; the end is not after now.
    bars : list of Bar
    decisions : Counter of Decision
    series : list of Series
        Most bars first.
    chart : ControlChart or None
        Of the deviations from the target; subgroups hold bars of one target only.
    alarms, faults : list of Lasting
        Longest first.
    ingots : Counter of str
        By orientation.
    running_share, available_share : float
        Of the shift: the appliance ran; it ran and had no fault of the class "failure".
    calibration : dict or None
        Newest row of the table of calibrations.
    versions : list of str
        Of the software that ran.
    simulated : bool
        Whether any bar or ingot was simulated or from a recording.
    """

    start: datetime
    end: datetime
    bars: list[Bar]
    decisions: Counter[Decision]
    series: list[Series]
    chart: ControlChart | None
    alarms: list[Lasting]
    faults: list[Lasting]
    ingots: Counter[str]
    running_share: float
    available_share: float
    calibration: dict[str, Any] | None
    versions: list[str]
    simulated: bool

    @property
    def out(self) -> list[Bar]:
        """Bars out of tolerance, farthest first."""
        out = [bar for bar in self.bars if bar["decision"] == Decision.OUT]
        return sorted(out, key=lambda bar: -abs(bar["deviation_mm"]))


def shifts(history: History, start: datetime, end: datetime, hours: float) -> Iterator[Shift]:
    """Shifts of a time, one after the other, each as soon as it is read.

    Parameters
    ----------
    history : History
    start, end : datetime
        With a time zone; nothing after now is reported.
    hours : float
        Length of a shift; the last may be shorter.

    Raises
    ------
    HistoryError
        The history is damaged.
    """
    end = min(end, datetime.now(tz=UTC)).astimezone()
    while start < end:
        next_start = min((start.astimezone(UTC) + timedelta(hours=hours)).astimezone(), end)
        yield read_shift(history, start, next_start)
        start = next_start


def read_shift(history: History, start: datetime, end: datetime) -> Shift:
    """One shift; see `shifts`."""
    frame = Interval(to_ms(start), to_ms(end))
    bars = list(history.rows(BARS, start, end))
    ingots = list(history.rows(INGOTS, start, end))
    runs = list(history.lasting(RUNS, "alive_utc_ms", start, end))
    faults = list(history.lasting(FAULT_ROWS, "gone_utc_ms", start, end))
    alarms = history.lasting(ALARM_ROWS, "gone_utc_ms", start, end)
    running = [_interval(run, "started_utc_ms", "alive_utc_ms", frame) for run in runs]
    failed = [row for row in faults if int(row["state"] or 0) == int(DeviceState.FAILURE)]
    failures = [_interval(row, "came_utc_ms", "gone_utc_ms", frame) for row in failed]
    series = list(_series(bars))
    return Shift(
        start,
        end,
        bars,
        Counter(Decision(int(bar["decision"] or 0)) for bar in bars),
        sorted(series, key=lambda one: -len(one.bars)),
        control_chart([group for one in series for group in subgroups([bar["deviation_mm"] for bar in one.bars])]),
        _lasting(list(alarms), {row.name: row.text for row in ALARMS}, frame),
        _lasting(faults, {row.name: row.text for row in FAULTS}, frame),
        Counter(str(ingot["orientation"]) for ingot in ingots),
        length_ms(running) / frame.length_ms,
        without(running, failures) / frame.length_ms,
        history.newest(CALIBRATIONS, end),
        sorted({str(run["version"]) for run in runs}),
        any(row["simulated"] for row in (*bars, *ingots)),
    )


def _series(bars: list[Bar]) -> Iterator[Series]:
    keys = ("target_mm", "tolerance_plus_mm", "tolerance_minus_mm", "grade")
    by_target: dict[tuple[Any, ...], list[Bar]] = {}
    for bar in bars:
        if bar["decision"] != Decision.NONE:
            by_target.setdefault(tuple(bar[key] for key in keys), []).append(bar)
    for (target_mm, plus_mm, minus_mm, grade), members in by_target.items():
        found = capability([bar["deviation_mm"] for bar in members], plus_mm, minus_mm)
        yield Series(target_mm, plus_mm, minus_mm, grade is not None, members, found)


def _interval(row: dict[str, Any], start: str, end: str, frame: Interval) -> Interval:
    """What of a row's time lies in a frame; a row without an end goes on."""
    end_ms = frame.end_ms if row[end] is None else row[end]
    return Interval(row[start], end_ms).within(frame)


def _lasting(rows: list[dict[str, Any]], texts: dict[str, str], frame: Interval) -> list[Lasting]:
    by_name: dict[str, list[Interval]] = {}
    for row in rows:
        by_name.setdefault(row["name"], []).append(_interval(row, "came_utc_ms", "gone_utc_ms", frame))
    found = [
        Lasting(
            name,
            texts.get(name, ""),
            len(intervals),
            length_ms(intervals) / 1000,
            max(interval.length_ms for interval in intervals) / 1000,
        )
        for name, intervals in by_name.items()
    ]
    return sorted(found, key=lambda one: -one.total_s)
