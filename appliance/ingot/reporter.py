"""What the ingot station tells the supervisor of each picture, and of the last ingots."""

import collections
import math
import time

from appliance.cameras.pacing import utc_ms
from appliance.cameras.source import Frame
from appliance.ingot.message import IngotMessage, IngotVerdict
from appliance.ingot.reader_setup import decision_rule
from appliance.ingot.settings import IngotSettings
from vision.ingot.sequential_decision import IngotDecision, IngotFollower
from vision.readings import OrientationReading

TOLD_AGAIN = 4  # ingots: more are not decided in the time of a few lost messages
UNSEEN_S = 3.0  # without a picture: chosen, shorter than a crane takes to exchange an ingot


class IngotReporter:
    """Follows the ingots of one camera and says what the supervisor must know.

    Parameters
    ----------
    settings : IngotSettings
    """

    def __init__(self, settings: IngotSettings) -> None:
        self._follower = IngotFollower(decision_rule(settings.decision))
        self._seen_s = math.inf  # before the first picture nothing is missed
        self._told: collections.deque[IngotVerdict] = collections.deque(maxlen=TOLD_AGAIN)

    def report(
        self, frame: Frame, reading: OrientationReading, elapsed_ms: float, *, dropped: int, simulated: bool
    ) -> IngotMessage:
        """What is said of one picture.

        Parameters
        ----------
        frame : Frame
        reading : OrientationReading
            Of that picture.
        elapsed_ms : float
            Time that reading took.
        dropped : int
            Messages discarded so far.
        simulated : bool
        """
        now_ms = utc_ms(time.monotonic())
        decisions = self._end_unseen(frame.exposed_monotonic_s) + self._follower.take(frame.sequence, reading)
        self._told.extend(_verdict(decision, now_ms) for decision in decisions)
        current = self._follower.current
        return IngotMessage(
            sequence=frame.sequence,
            exposed_monotonic_s=frame.exposed_monotonic_s,
            elapsed_ms=elapsed_ms,
            dropped=frame.dropped + dropped,
            simulated=simulated,
            reading=reading,
            current=None if current is None else _verdict(current, now_ms),
            told=tuple(self._told),
        )

    def _end_unseen(self, exposed_s: float) -> list[IngotDecision]:
        """End the ingot when the camera was away for so long that another one may lie there."""
        unseen_s, self._seen_s = exposed_s - self._seen_s, exposed_s
        return self._follower.end() if unseen_s > UNSEEN_S else []


def _verdict(decision: IngotDecision, now_ms: int) -> IngotVerdict:
    return IngotVerdict(
        ingot=decision.ingot,
        orientation=decision.orientation,
        confidence=decision.confidence,
        ssim_top=_number(decision.ssim_top),
        ssim_bottom=_number(decision.ssim_bottom),
        told_utc_ms=now_ms,
    )


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
