"""Faults of the gauge that show as a reason in all readings for a while."""

from appliance.sizing.message import ReadingMessage
from vision.reasons import Reason

LASTING_REASONS = {
    "contrast_low": Reason.LOW_CONTRAST,
    "calibration_due": Reason.CALIBRATION_DUE | Reason.CAMERA_MOVED,
}
"""Reasons that lead to each fault, by its name."""


class LastingReasons:
    """Faults that begin when a reason is in all readings of bars for `after_s`, and end when it is in none as long.

    Parameters
    ----------
    after_s : float
        Time for which a reason must be present, or absent, in all readings of bars, seconds.
    """

    def __init__(self, after_s: float) -> None:
        self._after_s = after_s
        self._since_s: dict[str, float] = {}
        self._active: set[str] = set()

    def add(self, message: ReadingMessage) -> None:
        """Count a new reading."""
        reasons = message.reading.reasons
        if Reason.NO_BAR in reasons:
            return
        for fault, bits in LASTING_REASONS.items():
            self._count(fault, message.exposed_monotonic_s, there=bool(reasons & bits))

    def faults(self) -> dict[str, bool]:
        """Whether each fault is active now, by name."""
        return {fault: fault in self._active for fault in LASTING_REASONS}

    def _count(self, fault: str, now_s: float, *, there: bool) -> None:
        if there == (fault in self._active):
            self._since_s.pop(fault, None)
        elif now_s - self._since_s.setdefault(fault, now_s) >= self._after_s:
            self._active ^= {fault}
            del self._since_s[fault]
