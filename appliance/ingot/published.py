"""Registers of the ingot station: the ingot on the line, and a ring of the last ingots for PLCs that poll slowly."""

from appliance.ingot.message import IngotMessage, IngotVerdict
from plc.codes import Orientation, Validity
from plc.rings import SLOTS
from plc.rows import Value
from vision.reasons import IngotReason

ORIENTATION_CODES = {"top": Orientation.TOP, "bottom": Orientation.BOTTOM, "undecided": Orientation.UNDECIDED}
GONE_PICTURES = 5  # without an end, in a row: chosen, as the follower's `gone_frames`; one picture may miss an end
LARGEST_AGE_MS = 0xFFFFFFFE  # largest age in a u32; 0xFFFFFFFF is "no value"


class IngotPublication:
    """The newest message of the ingot station, and whether it may be served.

    Parameters
    ----------
    stale_after_ms : int
        Age above which a picture is no longer served.

    Attributes
    ----------
    stale_after_ms : int
    simulated : bool
        Whether the pictures come from a simulation or a recording.
    stale : bool
        Whether there was a picture at the last `update`, older than `stale_after_ms`.
    """

    def __init__(self, stale_after_ms: int) -> None:
        self.simulated = False
        self.stale_after_ms = stale_after_ms
        self.stale = False
        self._newest: IngotMessage | None = None
        self._standing: IngotMessage | None = None
        self._age_ms = 0.0
        self._without_picture = IngotReason.STARTING
        self._reasons = IngotReason.STARTING
        self._before = 0  # ingots of the processes that have ended
        self._ingots = 0
        self._published = 0  # number of the newest ingot in the ring
        self._top_lies = False
        self._empty_pictures = 0
        self._index = 0
        self._ring: dict[str, Value] = {}

    def add(self, message: IngotMessage) -> dict[int, IngotVerdict]:
        """Replace the newest picture; `update` decides whether it may be served.

        Returns
        -------
        dict of int to IngotVerdict
            What is told for the first time, by number of the ingot since the start of the appliance.
        """
        self._newest = message
        self.simulated = message.simulated
        told: dict[int, IngotVerdict] = {}
        for verdict in message.told:
            if self._before + verdict.ingot > self._published:
                self._write(verdict)
                told[self._published] = verdict
        if message.current is not None:
            self._ingots = max(self._ingots, self._before + message.current.ingot)
        self._watch_top(message)
        return told

    def withdraw(self, reason: IngotReason, *, restarted: bool) -> None:
        """Serve no picture until the next `add`.

        Parameters
        ----------
        reason : IngotReason
            Stands in the reason word.
        restarted : bool
            Whether the process has ended; the next one counts its ingots from 1 again.
        """
        self._newest = None
        self._without_picture = reason
        if restarted:
            self._before = self._published = self._ingots

    def update(self, now_s: float, *, held: bool) -> None:
        """Decide what may be served at `now_s`.

        Parameters
        ----------
        now_s : float
            Monotonic time at which the registers are published.
        held : bool
            The PLC holds the gauge: nothing is served.
        """
        newest = self._newest
        self._age_ms = 0.0 if newest is None else max(0.0, 1000 * (now_s - newest.exposed_monotonic_s))
        self.stale = newest is not None and self._age_ms > self.stale_after_ms
        self._standing = None if held or self.stale else newest
        reasons = self._without_picture if newest is None else newest.reading.reasons
        self._reasons = reasons | (IngotReason.STALE if self.stale else 0) | (IngotReason.HELD if held else 0)

    @property
    def wrong_orientation(self) -> bool:
        """Whether an ingot that was decided to show its top lies on the line, as far as anybody knows.

        A camera that is lost, a stale picture or a new process says nothing of the ingot: it ends with pictures that
        show the line empty, or with an ingot that is decided to show its bottom.
        """
        return self._top_lies

    def _watch_top(self, message: IngotMessage) -> None:
        orientation = message.current.orientation if message.current is not None else None
        empty = message.current is None and not message.reading.present
        self._empty_pictures = self._empty_pictures + 1 if empty else 0
        if orientation == "top":
            self._top_lies = True
        elif orientation == "bottom" or self._empty_pictures >= GONE_PICTURES:
            self._top_lies = False

    def values(self) -> dict[str, Value]:
        """Values of the registers at the last `update`, by name; None and NaN are "no value"."""
        values: dict[str, Value] = {
            "ingot_reason_word": self._reasons,
            "ingot_sequence": self._ingots,
            "ingot_ring_index": self._index,
        }
        if self._newest is not None:
            values["ingot_age"] = min(round(self._age_ms), LARGEST_AGE_MS)
        if self._standing is not None:
            reading = self._standing.reading
            values |= {"ssim_top": reading.ssim_top, "ssim_bottom": reading.ssim_bottom}
            values |= {"ingot_present": reading.present} | _known(self._standing.current, self._reasons)
        return values | self._ring

    def _write(self, verdict: IngotVerdict) -> None:
        """Write an ingot over the oldest in the ring."""
        self._published = self._before + verdict.ingot
        self._ingots = max(self._ingots, self._published)
        slot = f"ingot_{self._index % SLOTS}_"
        values: dict[str, Value] = {
            "timestamp": verdict.told_utc_ms,
            "ssim_top": verdict.ssim_top,
            "ssim_bottom": verdict.ssim_bottom,
            "confidence": verdict.confidence,
            "sequence": self._published,
            "validity": Validity.NONE if verdict.orientation == "undecided" else Validity.VALID,
            "orientation": ORIENTATION_CODES[verdict.orientation],
        }
        self._ring |= {slot + name: value for name, value in values.items()}
        self._index += 1


def _known(verdict: IngotVerdict | None, reasons: IngotReason) -> dict[str, Value]:
    """Orientation, confidence and validity of the ingot on the line."""
    if verdict is None:
        return {}
    validity = Validity.NONE
    if verdict.orientation != "undecided":
        validity = Validity.VALID_WITH_REASONS if reasons else Validity.VALID
    return {
        "ingot_orientation": ORIENTATION_CODES[verdict.orientation],
        "ingot_confidence": verdict.confidence,
        "ingot_validity": validity,
    }
