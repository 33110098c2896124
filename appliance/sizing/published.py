"""What the sizing station puts into the registers: the newest reading, as long as it may stand."""

from appliance.sizing.message import ReadingMessage
from plc.rows import Value

# Bits of `reason_word` that are known without the vision library; a test compares them with its table.
NO_BAR = 1 << 0
NO_PAIR = 1 << 7
STALE = 1 << 8
STARTING = 1 << 9
HELD = 1 << 11
CAMERA_MOVED = 1 << 14
BAR_TOO_SHORT = 1 << 15
LOW_CONTRAST = 1 << 17
CALIBRATION_DUE = 1 << 25
BAR_HEAD = 1 << 27
BAR_TAIL = 1 << 28

AGE_LARGEST_MS = 0xFFFE  # one more is "no value"


class Publication:
    """The newest reading of the sizing station and what of it may be served.

    Parameters
    ----------
    stale_after_ms : int
        Age from which a reading is no value any more.

    Attributes
    ----------
    stale_after_ms : int
    held : bool
        The PLC holds the gauge: no reading stands.
    """

    def __init__(self, stale_after_ms: int) -> None:
        self.held = False
        self.stale_after_ms = stale_after_ms
        self._reading: ReadingMessage | None = None
        self._cycle_time_ms: float | None = None
        self._dropped = 0
        self._dropped_by_source = 0
        self._without_reading = STARTING
        self._sequence = 0
        self._quality: tuple[int, int] | None = None

    def take(self, reading: ReadingMessage) -> None:
        """Let a new reading stand in place of the one before."""
        before = self._reading
        if before is not None:
            self._cycle_time_ms = 1000 * (reading.exposed_monotonic_s - before.exposed_monotonic_s)
        # a source counts from its own start, so a smaller number is a new count
        again = reading.dropped < self._dropped_by_source
        self._dropped += reading.dropped - (0 if again else self._dropped_by_source)
        self._dropped_by_source = reading.dropped
        self._reading = reading
        self._quality = None
        self._sequence += 1

    def withdraw(self, reason: int) -> None:
        """Let no reading stand; `reason`, a bit of `reason_word`, says why."""
        self._reading = None
        self._cycle_time_ms = None
        self._without_reading = reason

    def stale(self, now_s: float) -> bool:
        """Whether there is a reading and it is too old to stand."""
        return self._reading is not None and _age_ms(self._reading, now_s) > self.stale_after_ms

    def standing(self, now_s: float) -> ReadingMessage | None:
        """The reading that may be served; None when there is none, it is stale or the gauge is held."""
        return None if self.held or self.stale(now_s) else self._reading

    def values(self, now_s: float) -> dict[str, Value]:
        """Values of the registers at one moment, by name; None is "no value".

        Parameters
        ----------
        now_s : float
            Monotonic time of the swap.
        """
        reading = self.standing(now_s)
        reasons = self._reasons(now_s)
        validity = (2 if reasons else 1) if reading is not None and reading.valid else 0
        self._count(validity, reasons)
        quality = {"sequence": self._sequence, "validity": validity, "reason_word": reasons}
        return quality | self._moment(now_s) | _measurements(reading)

    def _reasons(self, now_s: float) -> int:
        held = HELD if self.held else 0
        if self._reading is None:
            return held | self._without_reading
        return held | self._reading.reasons | (STALE if self.stale(now_s) else 0)

    def _count(self, validity: int, reasons: int) -> None:
        """Count a change of validity; a new reading has been counted when it came."""
        quality = (validity, reasons)
        if self._quality is not None and quality != self._quality:
            self._sequence += 1
        self._quality = quality
        self._sequence &= 0xFFFF

    def _moment(self, now_s: float) -> dict[str, Value]:
        reading = self._reading
        moment: dict[str, Value] = {"frames_dropped": self._dropped, "cycle_time": self._cycle_time_ms}
        if reading is not None:
            moment["measurement_age"] = min(round(_age_ms(reading, now_s)), AGE_LARGEST_MS)
            moment["timestamp"] = reading.exposed_utc_ms
        return moment


def _age_ms(reading: ReadingMessage, now_s: float) -> float:
    return max(0.0, 1000 * (now_s - reading.exposed_monotonic_s))


def _measurements(reading: ReadingMessage | None) -> dict[str, Value]:
    if reading is None:
        return {}
    return {
        "measurement_valid": reading.valid,
        "bar_present": not reading.reasons & NO_BAR,
        "diameter": reading.diameter_mm if reading.valid else None,
        "expanded_uncertainty": reading.expanded_uncertainty_mm if reading.valid else None,
        "diameter_virtual_board": reading.diameter_virtual_board_mm,
        "weighted_deviation": reading.weighted_deviation_mm,
        "alignment_quality": reading.alignment_quality,
        "plane_height": reading.plane_height_mm,
        "windows_kept": reading.windows_kept,
        "windows_total": reading.windows_total,
    }
