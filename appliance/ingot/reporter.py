"""Makes the ingot station's message of each picture, with the last decisions on ingots."""

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

REPEATED_DECISIONS = 4  # chosen: each message repeats the last 4 decisions, so a few lost messages lose no ingot
UNSEEN_S = 3.0  # without a picture: chosen, shorter than a crane takes to exchange an ingot


class IngotReporter:
    """Follows the ingots of one camera from picture to picture and makes the messages for the supervisor.

    Parameters
    ----------
    settings : IngotSettings
    """

    def __init__(self, settings: IngotSettings) -> None:
        self._follower = IngotFollower(decision_rule(settings.decision))
        self._stretch = 0
        self._seen_s = math.inf  # before the first picture nothing is missed
        self._decided: collections.deque[IngotVerdict] = collections.deque(maxlen=REPEATED_DECISIONS)

    @property
    def current(self) -> IngotDecision | None:
        """Decision on the ingot on the line, or its evidence so far; None without an ingot."""
        return self._follower.current

    def report(
        self, frame: Frame, reading: OrientationReading, elapsed_ms: float, *, dropped: int, simulated: bool
    ) -> IngotMessage:
        """Make the message of one picture.

        Parameters
        ----------
        frame : Frame
        reading : OrientationReading
            Of that picture.
        elapsed_ms : float
            Computing time of the reading.
        dropped : int
            Messages discarded since the process started.
        simulated : bool
            Whether the pictures come from a simulation or a recording.
        """
        now_ms = utc_ms(time.monotonic())
        decisions = self._end_unseen(frame) + self._follower.add(frame.sequence, reading)
        self._decided.extend(_verdict(decision, now_ms) for decision in decisions)
        current = self._follower.current
        return IngotMessage(
            sequence=frame.sequence,
            exposed_monotonic_s=frame.exposed_monotonic_s,
            elapsed_ms=elapsed_ms,
            dropped=frame.dropped + dropped,
            simulated=simulated,
            reading=reading,
            current=None if current is None else _verdict(current, now_ms),
            told=tuple(self._decided),
        )

    def _end_unseen(self, frame: Frame) -> list[IngotDecision]:
        """End the ingot when the camera was away for so long that another may lie there, or a recording jumped."""
        unseen_s, self._seen_s = frame.exposed_monotonic_s - self._seen_s, frame.exposed_monotonic_s
        stretch_before, self._stretch = self._stretch, frame.stretch
        return self._follower.end() if unseen_s > UNSEEN_S or frame.stretch != stretch_before else []


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
