"""Charts of a shift as SVG, told apart without colour: they are printed."""

import importlib
import io
from datetime import UTC, datetime
from typing import Any

from appliance.reports.control_chart import ControlChart
from appliance.reports.shift import Bar, Shift
from plc.codes import Decision

WIDTH_INCH = 7.3  # a page of A4 within its margins
TREND_HEIGHT_INCH = 1.8
CONTROL_HEIGHT_INCH = 1.9
_LOOK = {"font.size": 8, "axes.spines.top": False, "axes.spines.right": False, "svg.fonttype": "path"}
_MARKS = {
    Decision.IN: {"marker": "o", "color": "#1b5e20", "markersize": 2.5},
    Decision.UNDECIDED: {"marker": "D", "color": "#b26a00", "markersize": 4, "markerfacecolor": "none"},
    Decision.OUT: {"marker": "X", "color": "#b00020", "markersize": 6},
}


def trend(shift: Shift) -> str:
    """Deviation of each bar from its target over time, with U and the tolerance; empty without decided bars."""
    bars = sorted((bar for series in shift.series for bar in series.bars), key=lambda bar: bar["started_utc_ms"])
    if not bars:
        return ""
    figure, (axes,) = new_figure(TREND_HEIGHT_INCH, 1, 1)
    times = [_time(bar) for bar in bars]
    deviations = [bar["deviation_mm"] for bar in bars]
    expanded = [_expanded_mm(bar) for bar in bars]
    axes.errorbar(times, deviations, yerr=expanded, fmt="none", ecolor="#b0b0b0", elinewidth=0.6, zorder=1)
    for decision, mark in _MARKS.items():
        chosen = [
            (when, bar["deviation_mm"]) for when, bar in zip(times, bars, strict=True) if bar["decision"] == decision
        ]
        if chosen:
            label = f"{decision.text} ({len(chosen)})"
            axes.plot(*zip(*chosen, strict=True), linestyle="none", zorder=2, label=label, **mark)
    for sign, name in ((1, "tolerance_plus_mm"), (-1, "tolerance_minus_mm")):
        axes.step(times, [sign * bar[name] for bar in bars], where="post", color="black", linewidth=1, linestyle="--")
    axes.axhline(0, color="black", linewidth=0.5)
    axes.set_ylabel("deviation, mm")
    axes.set_xlim(shift.start, shift.end)
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False, borderaxespad=0.2)
    _local_time(axes, shift.start)
    return svg_of(figure)


def control(chart: ControlChart) -> str:
    """Means and ranges of the subgroups with their limits; those outside are ringed."""
    figure, (means, ranges) = new_figure(CONTROL_HEIGHT_INCH, 2, 1)
    levels = ((chart.center, "-"), (chart.lower, "--"), (chart.upper, "--"))
    _draw(means, chart.means, levels, chart.means_outside)
    means.set_ylabel("means, mm")
    range_levels = ((chart.range_center, "-"), (chart.range_upper, "--"))
    _draw(ranges, chart.ranges, range_levels, chart.ranges_outside)
    ranges.set_ylabel("ranges, mm")
    ranges.set_ylim(bottom=0)
    ranges.set_xlabel("subgroup of five consecutive bars")
    return svg_of(figure)


def _draw(axes: Any, values: tuple[float, ...], levels: tuple[tuple[float, str], ...], outside: list[int]) -> None:
    numbers = range(1, len(values) + 1)
    axes.plot(numbers, values, marker=".", color="#1f4e79", linewidth=0.8, markersize=4)
    style = {"markersize": 9, "markerfacecolor": "none", "color": "#b00020", "linestyle": "none", "clip_on": False}
    if outside:  # an empty line that is not clipped has no extent, and the layout none either
        axes.plot([numbers[number] for number in outside], [values[number] for number in outside], marker="o", **style)
    for level, line in levels:
        axes.axhline(level, color="black", linewidth=0.8, linestyle=line)
        axes.annotate(f" {level:.2f}", (1, level), xycoords=("axes fraction", "data"), va="center", fontsize=7)
    lowest, highest = (pick((*values, *(level for level, _ in levels))) for pick in (min, max))
    room = 0.15 * (highest - lowest)
    axes.set_ylim(lowest - room, highest + room)
    axes.set_xlim(0.5, len(numbers) + 0.5)


def new_figure(height_inch: float, rows: int, columns: int) -> tuple[Any, list[Any]]:
    """A figure as wide as a page of A4 within its margins, and its axes, row by row.

    Parameters
    ----------
    height_inch : float
    rows, columns : int
        Of axes; those of a column share what is across.
    """
    matplotlib: Any = importlib.import_module("matplotlib")
    matplotlib.rcParams.update(_LOOK)
    figure: Any = importlib.import_module("matplotlib.figure").Figure((WIDTH_INCH, height_inch), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex="col")
    return figure, list(axes.ravel())


def _local_time(axes: Any, start: datetime) -> None:
    dates: Any = importlib.import_module("matplotlib.dates")
    axes.xaxis.set_major_locator(dates.AutoDateLocator(minticks=4, maxticks=10))
    axes.xaxis.set_major_formatter(dates.DateFormatter("%H:%M", tz=start.tzinfo))


def svg_of(figure: Any) -> str:
    """SVG text of a figure."""
    text = io.StringIO()
    figure.savefig(text, format="svg")
    return text.getvalue()


def _time(bar: Bar) -> datetime:
    return datetime.fromtimestamp(bar["started_utc_ms"] / 1000, tz=UTC)


def _expanded_mm(bar: Bar) -> float:
    cold = bar["grade"] is not None
    return bar["expanded_uncertainty_cold_mm" if cold else "expanded_uncertainty_mm"] or 0.0
