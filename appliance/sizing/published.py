"""Registers of the sizing station: the newest reading until it is stale, withdrawn or held."""

from collections.abc import Callable

from appliance.sizing.message import ReadingMessage
from plc.codes import Validity
from plc.rows import Value
from vision.readings import SizeReading
from vision.reasons import Reason

LARGEST_AGE_MS = 0xFFFE  # largest age in a u16; 0xFFFF is "no value"


MATCH_PERCENT = 99.0  # within an offset of 1 % of the bar's width: half a pixel on the narrowest bars


def _settled(quality: float | None) -> float | None:
    """Alignment quality with a sign only where it says something: at a match it would change from frame to frame."""
    return quality if quality is None or abs(quality) < MATCH_PERCENT else abs(quality)


PUBLISHED: dict[str, Callable[[SizeReading], Value]] = {
    "measurement_valid": lambda reading: reading.valid,
    "bar_present": lambda reading: Reason.NO_BAR not in reading.reasons,
    "diameter": lambda reading: reading.diameter_mm if reading.valid else None,
    "expanded_uncertainty": lambda reading: reading.expanded_uncertainty_mm if reading.valid else None,
    "bar_frames": lambda reading: reading.bar_frames if reading.valid and reading.bar_frames else None,
    "bar_diameter": lambda reading: reading.bar_diameter_mm if reading.valid else None,
    "bar_expanded_uncertainty": lambda reading: reading.bar_expanded_uncertainty_mm if reading.valid else None,
    "bar_ovality": lambda reading: reading.bar_ovality_mm if reading.valid else None,
    "bar_ovality_expanded_uncertainty": lambda reading: (
        reading.bar_ovality_expanded_uncertainty_mm if reading.valid else None
    ),
    "camber": lambda reading: reading.camber_mm if reading.valid else None,
    "camber_expanded_uncertainty": lambda reading: 2 * reading.u_camber_mm if reading.valid else None,
    "hop_height": lambda reading: reading.axis_height_mm - reading.diameter_mm / 2 if reading.valid else None,
    "diameter_virtual_board": lambda reading: reading.diameter_virtual_board_mm,
    "weighted_deviation": lambda reading: reading.weighted_deviation_mm,
    "alignment_quality": lambda reading: _settled(reading.alignment_quality),
    "plane_height": lambda reading: reading.plane_height_mm,
    "windows_kept": lambda reading: reading.windows_kept,
    "windows_total": lambda reading: reading.windows_total,
}
"""Quantities of a reading, by the name of their register; NaN and None become "no value" there."""


def _validity(reading: SizeReading) -> Validity:
    if not reading.valid:
        return Validity.NONE
    return Validity.VALID_WITH_REASONS if reading.reasons else Validity.VALID


PUBLISHED_OF_BARS: dict[str, Callable[[SizeReading], Value]] = {
    "diameter": PUBLISHED["diameter"],
    "expanded_uncertainty": PUBLISHED["expanded_uncertainty"],
    "mean_diameter": PUBLISHED["bar_diameter"],
    "mean_expanded_uncertainty": PUBLISHED["bar_expanded_uncertainty"],
    "offset": lambda reading: reading.offset_mm if reading.valid else None,
    "validity": _validity,
    "reason_word": lambda reading: reading.reasons,
}
"""Quantities of each of several bars side by side, by the field of their slot."""


class Publication:
    """The newest reading of the sizing station, and whether it may be served.

    Parameters
    ----------
    stale_after_ms : int
        Age above which a reading is no longer served.

    Attributes
    ----------
    stale_after_ms : int
    stale : bool
        Whether there was a reading at the last `update`, older than `stale_after_ms`.
    standing : ReadingMessage or None
        The reading that may be served; None when there is none, it is stale or the PLC holds the gauge.
    """

    def __init__(self, stale_after_ms: int) -> None:
        self.stale_after_ms = stale_after_ms
        self.stale = False
        self.standing: ReadingMessage | None = None
        self._newest: ReadingMessage | None = None
        self._age_ms = 0.0
        self._cycle_time_ms: float | None = None
        self._dropped = 0
        self._dropped_by_source = 0
        self._without_reading = Reason.STARTING
        self._reasons = Reason.STARTING
        self._validity = Validity.NONE
        self._sequence = 0
        self._counted: tuple[Validity, Reason] | None = None

    def add(self, message: ReadingMessage) -> None:
        """Replace the newest reading; `update` decides whether it may be served."""
        before = self._newest
        if before is not None:
            self._cycle_time_ms = 1000 * (message.exposed_monotonic_s - before.exposed_monotonic_s)
        # each process counts from 0, so a smaller number belongs to a new process
        again = message.dropped < self._dropped_by_source
        self._dropped += message.dropped - (0 if again else self._dropped_by_source)
        self._dropped_by_source = message.dropped
        self._newest = message
        self._counted = None
        self._sequence += 1

    def withdraw(self, reason: Reason) -> None:
        """Serve no reading until the next `add`; `reason` stands in the reason word."""
        self._newest = None
        self._cycle_time_ms = None
        self._without_reading = reason
        if reason is Reason.STARTING:
            self._dropped_by_source = 0  # a new process counts from 0

    def update(self, now_s: float, *, held: bool) -> None:
        """Decide what may be served at `now_s`, and count a change of validity or reasons in `sequence`.

        Parameters
        ----------
        now_s : float
            Monotonic time at which the registers are published.
        held : bool
            The PLC holds the gauge: no reading is served.
        """
        newest = self._newest
        self._age_ms = 0.0 if newest is None else max(0.0, 1000 * (now_s - newest.exposed_monotonic_s))
        self.stale = newest is not None and self._age_ms > self.stale_after_ms
        self.standing = None if held or self.stale else newest
        reasons = self._without_reading if newest is None else newest.reading.reasons
        self._reasons = reasons | (Reason.STALE if self.stale else 0) | (Reason.HELD if held else 0)
        self._validity = Validity.NONE
        if self.standing is not None and self.standing.reading.valid:
            self._validity = Validity.VALID_WITH_REASONS if self._reasons else Validity.VALID
        self._count()

    def values(self) -> dict[str, Value]:
        """Values of the registers at the last `update`, by name; None and NaN are "no value"."""
        values: dict[str, Value] = {
            "sequence": self._sequence,
            "validity": self._validity,
            "reason_word": self._reasons,
            "frames_dropped": self._dropped,
            "cycle_time": self._cycle_time_ms,
        }
        if self._newest is not None:
            values["measurement_age"] = min(round(self._age_ms), LARGEST_AGE_MS)
            values["timestamp"] = self._newest.exposed_utc_ms
        if self.standing is not None:
            values |= {register: value(self.standing.reading) for register, value in PUBLISHED.items()}
            values["bars_count"] = sum(Reason.NO_BAR not in bar.reasons for bar in self.standing.bars)
            for number, bar in enumerate(self.standing.bars, start=1):
                values |= {f"bar_{number}_{field}": value(bar) for field, value in PUBLISHED_OF_BARS.items()}
        return values

    def _count(self) -> None:
        """Count a change of validity or reasons; `add` has counted a new reading."""
        now = (self._validity, self._reasons)
        if self._counted is not None and now != self._counted:
            self._sequence += 1
        self._counted = now
        self._sequence &= 0xFFFF
