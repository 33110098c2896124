"""Reads the gauge four times a second, once for all browsers, and remembers the last minutes for the trend."""

import contextlib
import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from appliance.conformity.set_points import SetPoints
from appliance.page.drawing import Point
from plc.client import press
from plc.codes import Decision, Validity
from plc.poll import Place, PollError, Snapshot, connect, scan

SCAN_PERIOD_S = 0.25  # a killed station shows within 2 s: 0.8 s until it is stale, this, and the browser's 0.5 s
RETRY_PAUSE_S = 0.5  # chosen
OLD_AFTER_S = 1.5  # chosen: what was read before then is not shown any more
TREND_S = 300.0  # chosen
BARS_KEPT = 8  # chosen
NO_SET_POINTS = SetPoints()

logger = logging.getLogger("hotgauge.page")


@dataclass(frozen=True, slots=True)
class Bar:
    """Last words of the registers on one bar."""

    number: int
    smallest_mm: float | None
    mean_mm: float | None
    largest_mm: float | None
    readings_out: bool


class Watch:
    """The gauge as the page sees it.

    Parameters
    ----------
    place : Place
    own : SetPoints
        Of the settings: what counts as long as the PLC has not written it, and stands in no register.
    clock : callable
        Monotonic time, seconds.
    """

    def __init__(
        self, place: Place, own: SetPoints = NO_SET_POINTS, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.place = place
        self._own = own
        self._clock = clock
        self._newest: tuple[float, Snapshot] | None = None
        self._trouble = ""
        self._trend: deque[Point] = deque(maxlen=round(TREND_S / SCAN_PERIOD_S))
        self._bars: deque[Bar] = deque(maxlen=BARS_KEPT)
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True, name="watch")

    def start(self) -> None:
        """Begin to read."""
        self._thread.start()

    def stop(self) -> None:
        """Read no more."""
        self._stopped.set()
        self._thread.join()

    @property
    def newest(self) -> Snapshot | None:
        """What was read last; None if it is too old to be shown."""
        newest = self._newest
        return newest[1] if newest is not None and self._clock() - newest[0] < OLD_AFTER_S else None

    @property
    def trouble(self) -> str:
        """Why there is nothing to be shown; empty if there is."""
        return "" if self.newest is not None else self._trouble or f"{self.place}: not read yet"

    @property
    def trend(self) -> list[Point]:
        """Size that is judged, of the last minutes, oldest first; moments are monotonic time."""
        since_s = self._clock() - TREND_S
        return [point for point in list(self._trend) if point.moment_s >= since_s]

    @property
    def bars(self) -> list[Bar]:
        """The last bars, newest first."""
        return list(self._bars)[::-1]

    def wanted(self, snapshot: Snapshot) -> SetPoints:
        """What is wanted of a bar: what the PLC has written, else what the settings say."""
        points = snapshot.set_points
        grade = points["expansion_grade"]
        written = SetPoints(
            points["target_diameter"],
            points["tolerance_plus"],
            points["tolerance_minus"],
            points["steel_temperature"],
            None if grade is None else int(grade),
        )
        return written.over(self._own)

    def acknowledge(self) -> None:
        """Acknowledge all alarms, as the PLC does; raises `PollError`."""
        press(self.place, "acknowledge")

    def _run(self) -> None:
        while not self._stopped.is_set():
            try:
                with contextlib.closing(connect(self.place)) as client:
                    while not self._stopped.wait(SCAN_PERIOD_S):
                        self.add(scan(client, str(self.place), self.place.word_order))
            except PollError as error:
                self._trouble = str(error)
            except Exception as error:  # a mistake of our own ends no page: it is told and read again
                logger.exception("%s", self.place)
                self._trouble = f"{self.place}: cannot be read ({error!r}); send the log to the maker"
            self._stopped.wait(RETRY_PAUSE_S)

    def add(self, snapshot: Snapshot) -> None:
        """Take what was read, unless it is of two moments or in another order of words."""
        if not snapshot.word_order_fits:
            self._trouble = (
                f"{self.place}: the test value reads wrongly; check plc.word_order, and that this is a gauge"
            )
            return
        if not snapshot.whole:
            return
        before = self._newest
        self._newest = (self._clock(), snapshot)
        if before is None or before[1].values["sequence"] != snapshot.values["sequence"]:
            self._trend.append(Point(self._clock(), *self._judged(snapshot)))
        self._add_bar(snapshot)

    def _judged(self, snapshot: Snapshot) -> tuple[float | None, float | None]:
        """Size that deviation and decision are of, and its U, mm: cold if a grade is set, else hot."""
        values = snapshot.values
        if values["validity"] == int(Validity.NONE):
            return None, None
        if self.wanted(snapshot).grade is not None:
            return values["diameter_cold"], values["expanded_uncertainty_cold"]
        return values["diameter"], values["expanded_uncertainty"]

    def _add_bar(self, snapshot: Snapshot) -> None:
        values = snapshot.values
        number, mean_mm = int(values["bar_sequence"] or 0), values["bar_mean"]
        if mean_mm is None:
            return
        last = self._bars[-1] if self._bars else None
        is_same = last is not None and last.number == number
        is_out = values["decision"] == int(Decision.OUT) or (is_same and last is not None and last.readings_out)
        bar = Bar(number, values["bar_min"], mean_mm, values["bar_max"], is_out)
        if is_same:
            self._bars[-1] = bar
        else:
            self._bars.append(bar)
