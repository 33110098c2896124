"""Faults of the gauge that show as a reason in all readings for a while."""

from appliance.diagnostics.persistence import Persistence
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
        self._persistence = {fault: Persistence(after_s) for fault in LASTING_REASONS}

    def add(self, message: ReadingMessage) -> None:
        """Count a new reading."""
        reasons = message.reading.reasons
        if Reason.NO_BAR in reasons:
            return
        for fault, bits in LASTING_REASONS.items():
            self._persistence[fault].add(message.exposed_monotonic_s, there=bool(reasons & bits))

    def faults(self) -> dict[str, bool]:
        """Whether each fault is active now, by name."""
        return {fault: persistence.lasts for fault, persistence in self._persistence.items()}
