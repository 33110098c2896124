"""Reasons that last and so become faults of the gauge."""

from appliance.sizing.message import ReadingMessage
from appliance.sizing.published import CALIBRATION_DUE, CAMERA_MOVED, LOW_CONTRAST, NO_BAR

LASTING = {
    "contrast_low": LOW_CONTRAST,
    "calibration_due": CALIBRATION_DUE | CAMERA_MOVED,
}


class Lasting:
    """Faults that single readings only hint at: reasons that stay for a while.

    Parameters
    ----------
    after_s : float
        How long a reason must be there, or be gone, in all readings of bars.
    """

    def __init__(self, after_s: float) -> None:
        self._after_s = after_s
        self._since_s: dict[str, float] = {}
        self._active: set[str] = set()

    def take(self, reading: ReadingMessage) -> dict[str, bool]:
        """Take a new reading into account; which faults are active now."""
        now_s = reading.exposed_monotonic_s
        if not reading.reasons & NO_BAR:
            for fault, bits in LASTING.items():
                self._see(fault, now_s, there=bool(reading.reasons & bits))
        return {fault: fault in self._active for fault in LASTING}

    def _see(self, fault: str, now_s: float, *, there: bool) -> None:
        if there == (fault in self._active):
            self._since_s.pop(fault, None)
        elif now_s - self._since_s.setdefault(fault, now_s) >= self._after_s:
            self._active ^= {fault}
            del self._since_s[fault]
