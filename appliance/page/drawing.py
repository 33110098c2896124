"""Sizes over time as SVG: U as a band, target and tolerance as lines.

It is drawn here because a library's drawing of one chart takes as long as several readings, and the trend is drawn anew
twice a second.
"""

from collections.abc import Iterable, Sequence
from html import escape
from typing import NamedTuple

WIDTH, HEIGHT = 560.0, 240.0
LEFT, RIGHT, TOP, BOTTOM = 66.0, 10.0, 10.0, 30.0
SPAN_MIN_MM = 1.0  # chosen: noise of hundredths must not look like a swing
ROOM = 1.15  # chosen: of the span of sizes, so that none lies on the frame
LIMIT_NEAR_MM = 20.0  # chosen: a target that lies farther away is another product's and would flatten the sizes
GRID_LINES_MAX = 6
_STEPS_MM = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)


class Point(NamedTuple):
    """A size with its U at a moment; None for no value."""

    moment_s: float
    size_mm: float | None
    expanded_mm: float | None


class Limits(NamedTuple):
    """Target and limits of size, mm; None where they are not set."""

    target_mm: float | None
    lower_mm: float | None
    upper_mm: float | None


class Frame(NamedTuple):
    """What a chart shows beside its points.

    Attributes
    ----------
    start_s, end_s : float
        Moments at its left and right ends.
    gap_s : float
        Points farther apart are not joined.
    ticks : sequence of (float, str)
        Moments that are named below it.
    label : str
        What it shows, for those who do not see it.
    decimal : str
        Decimal sign.
    """

    start_s: float
    end_s: float
    gap_s: float
    ticks: Sequence[tuple[float, str]]
    label: str
    decimal: str = "."


class _Scale(NamedTuple):
    frame: Frame
    lowest_mm: float
    highest_mm: float

    def x(self, moment_s: float) -> float:
        share = (moment_s - self.frame.start_s) / (self.frame.end_s - self.frame.start_s)
        return LEFT + share * (WIDTH - LEFT - RIGHT)

    def y(self, size_mm: float) -> float:
        share = (size_mm - self.lowest_mm) / (self.highest_mm - self.lowest_mm)
        return HEIGHT - BOTTOM - min(max(share, 0), 1) * (HEIGHT - TOP - BOTTOM)


def chart(points: Sequence[Point], limits: Limits, frame: Frame) -> str:
    """Draw sizes over time; empty without any value.

    Parameters
    ----------
    points : sequence of Point
        In the order of time.
    limits : Limits
    frame : Frame
    """
    sizes = [point.size_mm for point in points if point.size_mm is not None]
    if not sizes:
        return ""
    near = [limit for limit in limits if limit is not None and _is_near(limit, sizes)]
    lowest_mm, highest_mm = min([*sizes, *near]), max([*sizes, *near])
    half_mm = max(SPAN_MIN_MM, ROOM * (highest_mm - lowest_mm)) / 2
    middle_mm = (lowest_mm + highest_mm) / 2
    scale = _Scale(frame, middle_mm - half_mm, middle_mm + half_mm)
    runs = list(_runs(points, frame.gap_s))
    parts = [
        f'<svg class="trend" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="{escape(frame.label)}">',
        *_grid(scale),
        *(_band(scale, run) for run in runs),
        *(_level(scale, limit, kind) for kind, limit in zip(("target", "limit", "limit"), limits, strict=True)),
        *(_path(scale, run) for run in runs),
        "</svg>",
    ]
    return "".join(parts)


def _is_near(limit_mm: float, sizes: Sequence[float]) -> bool:
    return min(sizes) - LIMIT_NEAR_MM <= limit_mm <= max(sizes) + LIMIT_NEAR_MM


def _runs(points: Iterable[Point], gap_s: float) -> Iterable[list[tuple[float, float, float]]]:
    """Points that are joined: moment, size and U."""
    run: list[tuple[float, float, float]] = []
    for point in points:
        if run and (point.size_mm is None or point.moment_s - run[-1][0] > gap_s):
            yield run
            run = []
        if point.size_mm is not None:
            run.append((point.moment_s, point.size_mm, point.expanded_mm or 0.0))
    if run:
        yield run


def _grid(scale: _Scale) -> Iterable[str]:
    span_mm = scale.highest_mm - scale.lowest_mm
    step_mm = next(step for step in (*_STEPS_MM, span_mm) if span_mm / step <= GRID_LINES_MAX)
    tick_mm = step_mm * -(-scale.lowest_mm // step_mm)
    while tick_mm <= scale.highest_mm:
        y = scale.y(tick_mm)
        yield f'<line class="grid" x1="{LEFT:g}" x2="{WIDTH - RIGHT:g}" y1="{y:.1f}" y2="{y:.1f}"/>'
        words = f"{tick_mm:.1f}".replace(".", scale.frame.decimal)
        yield f'<text x="{LEFT - 8:g}" y="{y + 6:.1f}" text-anchor="end">{words}</text>'
        tick_mm += step_mm
    for moment_s, words in scale.frame.ticks:
        x = scale.x(moment_s)
        anchor = "end" if x > WIDTH - RIGHT - 40 else "middle"
        yield f'<text x="{x:.1f}" y="{HEIGHT - 8:g}" text-anchor="{anchor}">{escape(words)}</text>'


def _level(scale: _Scale, size_mm: float | None, kind: str) -> str:
    if size_mm is None or not scale.lowest_mm <= size_mm <= scale.highest_mm:
        return ""
    y = scale.y(size_mm)
    return f'<line class="{kind}" x1="{LEFT:g}" x2="{WIDTH - RIGHT:g}" y1="{y:.1f}" y2="{y:.1f}"/>'


def _band(scale: _Scale, run: Sequence[tuple[float, float, float]]) -> str:
    upper = [(scale.x(moment_s), scale.y(size_mm + expanded_mm)) for moment_s, size_mm, expanded_mm in run]
    lower = [(scale.x(moment_s), scale.y(size_mm - expanded_mm)) for moment_s, size_mm, expanded_mm in reversed(run)]
    return f'<polygon class="band" points="{_points([*upper, *lower])}"/>'


def _path(scale: _Scale, run: Sequence[tuple[float, float, float]]) -> str:
    pairs = [(scale.x(moment_s), scale.y(size_mm)) for moment_s, size_mm, _ in run]
    drawn = pairs if len(pairs) > 1 else 2 * pairs  # a line of no length is drawn as a dot
    return f'<polyline class="size" points="{_points(drawn)}"/>'


def _points(pairs: Iterable[tuple[float, float]]) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in pairs)
