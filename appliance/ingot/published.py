"""What the ingot station puts into the registers: the ingot on the line, and the last ingots for slow PLCs."""

from appliance.ingot.message import IngotMessage, IngotVerdict
from plc.rings import SLOTS
from plc.rows import Value

# Bits of `ingot_reason_word` that are known without the vision library; a test compares them with its table.
NO_PICTURE = 1 << 7
STALE = 1 << 8
STARTING = 1 << 9
HELD = 1 << 10

ORIENTATIONS = {"top": 1, "bottom": 2, "undecided": 3}
AGE_LARGEST_MS = 0xFFFFFFFE  # one more is "no value"


class IngotPublication:
    """The newest picture of the ingot station and what of it may be served.

    Parameters
    ----------
    stale_after_ms : int
        Age from which a picture says nothing any more.

    Attributes
    ----------
    held : bool
        The PLC holds the gauge: nothing is served.
    stale_after_ms : int
    simulated : bool
        Whether the pictures are of a simulated line or of a recording.
    """

    def __init__(self, stale_after_ms: int) -> None:
        self.held = False
        self.simulated = False
        self.stale_after_ms = stale_after_ms
        self._message: IngotMessage | None = None
        self._without = STARTING
        self._before = 0  # ingots of the processes that have ended
        self._ingots = 0
        self._told = 0
        self._index = 0
        self._ring: dict[str, Value] = {}

    def take(self, message: IngotMessage) -> None:
        """Let a new picture stand in place of the one before."""
        self._message = message
        self.simulated = message.simulated
        for verdict in message.told:
            if self._before + verdict.ingot > self._told:
                self._write(verdict)
        if message.current is not None:
            self._ingots = max(self._ingots, self._before + message.current.ingot)

    def withdraw(self, reason: int, *, restarted: bool) -> None:
        """Let no picture stand; `reason`, a bit of `ingot_reason_word`, says why; a new process counts anew."""
        self._message = None
        self._without = reason
        if restarted:
            self._before = self._told = self._ingots

    def stale(self, now_s: float) -> bool:
        """Whether there is a picture and it is too old to stand."""
        return self._message is not None and _age_ms(self._message, now_s) > self.stale_after_ms

    def wrong_orientation(self, now_s: float) -> bool:
        """Whether the ingot on the line was decided to show its top."""
        message = self._standing(now_s)
        return message is not None and message.current is not None and message.current.orientation == "top"

    def values(self, now_s: float) -> dict[str, Value]:
        """Values of the registers at one moment, by name; None is "no value".

        Parameters
        ----------
        now_s : float
            Monotonic time of the swap.
        """
        message = self._standing(now_s)
        reasons = self._reasons(now_s)
        values: dict[str, Value] = {
            "ingot_reason_word": reasons,
            "ingot_sequence": self._ingots,
            "ingot_ring_index": self._index,
        }
        if self._message is not None:
            values["ingot_age"] = min(round(_age_ms(self._message, now_s)), AGE_LARGEST_MS)
        if message is not None:
            values |= {"ssim_top": message.ssim_top, "ssim_bottom": message.ssim_bottom}
            values |= {"ingot_present": message.present} | _known(message.current, reasons)
        return values | self._ring

    def _standing(self, now_s: float) -> IngotMessage | None:
        return None if self.held or self.stale(now_s) else self._message

    def _reasons(self, now_s: float) -> int:
        held = HELD if self.held else 0
        if self._message is None:
            return held | self._without
        return held | self._message.reasons | (STALE if self.stale(now_s) else 0)

    def _write(self, verdict: IngotVerdict) -> None:
        """Write an ingot over the oldest in the ring."""
        self._told = self._before + verdict.ingot
        self._ingots = max(self._ingots, self._told)
        slot = f"ingot_{self._index % SLOTS}_"
        values: dict[str, Value] = {
            "timestamp": verdict.told_utc_ms,
            "ssim_top": verdict.ssim_top,
            "ssim_bottom": verdict.ssim_bottom,
            "confidence": verdict.confidence,
            "sequence": self._told,
            "validity": int(verdict.orientation != "undecided"),
            "orientation": ORIENTATIONS[verdict.orientation],
        }
        self._ring |= {slot + name: value for name, value in values.items()}
        self._index += 1


def _age_ms(message: IngotMessage, now_s: float) -> float:
    return max(0.0, 1000 * (now_s - message.exposed_monotonic_s))


def _known(verdict: IngotVerdict | None, reasons: int) -> dict[str, Value]:
    """Orientation, confidence and validity of the ingot on the line."""
    if verdict is None:
        return {}
    validity = 0
    if verdict.orientation != "undecided":
        validity = 2 if reasons else 1
    return {
        "ingot_orientation": ORIENTATIONS[verdict.orientation],
        "ingot_confidence": verdict.confidence,
        "ingot_validity": validity,
    }
