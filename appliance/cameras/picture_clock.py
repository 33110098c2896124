"""When a picture was exposed, on this machine's monotonic clock. Pure: moments are given, none is read.

What waited in a queue (of the camera, the network or this machine) is older than its arrival tells. A camera that
stamps its pictures shows it: their distance from the arrival is smallest for a picture that did not wait. One
without them (JPEG over HTTP) shows it only by the rhythm of its arrivals: what comes out of rhythm is not measured.
"""

from collections import deque
from typing import NamedTuple, Protocol

from appliance.cameras.source import CameraError

SETTLE_S = 1.0  # of pictures on time, before the least delay is believed: servers send what they hold at once
SETTLED_S = 0.005  # a least delay that falls by no more has settled
DRIFT = 200e-6  # of two quartz clocks against each other: 100 ppm each, the loosest that cameras are built with
JUMP_S = 1.0  # a presentation time that runs ahead of the arrival by more is no network's doing
RHYTHM_WINDOW_S = 5.0
EARLY_SHARE, LATE_SHARE = 0.5, 2.5  # of the mean period: what comes earlier or later has waited, or came after a stall
AT_ONCE_S = 0.001  # a packet that was there so soon when asked for had been waiting
CAMERA_TIME_WITHIN_S = 15.0  # RTCP reports come every 5 s (RFC 3550, 6.2)


class Arrival(NamedTuple):
    """What is known of a decoded picture's time.

    Attributes
    ----------
    arrived_s : float
        Monotonic moment at which it was received.
    waited_s : float
        Time that the receiver had to wait for it.
    presented_s : float
        Presentation time, on a clock of the camera without a known beginning.
    camera_utc_s : float or None
        Moment on the camera's wall clock, seconds since 1970, from RTCP sender reports (RFC 3550, 6.4.1).
    arrived_utc_s : float
        Wall time of the arrival on this machine's clock.
    """

    arrived_s: float
    waited_s: float
    presented_s: float
    camera_utc_s: float | None
    arrived_utc_s: float


class StreamClock(Protocol):
    """Tells the moment of pictures that come one after the other."""

    def moment_s(self, arrival: Arrival) -> float | None:
        """Monotonic moment of exposure; None where it is not known well enough for the picture to be measured."""
        ...


class PresentationClock:
    """Moments by presentation times; the picture that waited least is taken for one that did not wait at all.

    Parameters
    ----------
    delay_s : float
        Time from exposure to arrival of a picture that did not wait.
    """

    def __init__(self, delay_s: float) -> None:
        self._delay_s = delay_s
        self._last: Arrival | None = None
        self._least_s = 0.0
        self._settling_since_s = 0.0

    def moment_s(self, arrival: Arrival) -> float | None:
        """Monotonic moment of exposure; raises `CameraError` (`camera_clock_wrong`) when presentation times jump."""
        lag_s = arrival.arrived_s - arrival.presented_s
        if self._last is None:
            self._least_s, self._settling_since_s = lag_s, arrival.arrived_s
        else:
            _refuse_jump(arrival, self._last)
            self._follow(lag_s, arrival.arrived_s, self._last.arrived_s)
        self._last = arrival
        if arrival.arrived_s - self._settling_since_s < SETTLE_S:
            return None
        return arrival.presented_s + self._least_s - self._delay_s

    def _follow(self, lag_s: float, now_s: float, before_s: float) -> None:
        drifted_s = self._least_s + DRIFT * (now_s - before_s)
        if lag_s < self._least_s - SETTLED_S:
            self._settling_since_s = now_s
        self._least_s = min(drifted_s, lag_s)


def _refuse_jump(arrival: Arrival, before: Arrival) -> None:
    step_s = arrival.presented_s - before.presented_s
    if step_s < 0:
        raise CameraError(f"presentation time goes back by {-step_s:.2f} s", "camera_clock_wrong")
    ahead_s = step_s - (arrival.arrived_s - before.arrived_s)
    if ahead_s > JUMP_S:
        raise CameraError(f"presentation time jumps ahead by {ahead_s:.2f} s", "camera_clock_wrong")


class RhythmClock:
    """Moments by arrival, of pictures that come in rhythm; for streams without presentation times.

    The rhythm is the mean period of the last seconds: a stall with a burst after it does not change how many come.

    Parameters
    ----------
    delay_s : float
        Time from exposure to arrival.
    """

    def __init__(self, delay_s: float) -> None:
        self._delay_s = delay_s
        self._arrivals_s: deque[float] = deque()
        self._first_s: float | None = None

    def moment_s(self, arrival: Arrival) -> float | None:
        """Monotonic moment of exposure; None for a picture out of rhythm, and before there is one."""
        now_s = arrival.arrived_s
        self._first_s = now_s if self._first_s is None else self._first_s
        before_s = self._arrivals_s[-1] if self._arrivals_s else now_s
        self._arrivals_s.append(now_s)
        while self._arrivals_s[0] < now_s - RHYTHM_WINDOW_S:
            self._arrivals_s.popleft()
        if now_s - self._first_s < SETTLE_S or len(self._arrivals_s) < 3:
            return None
        period_s = (now_s - self._arrivals_s[0]) / (len(self._arrivals_s) - 1)
        in_rhythm = EARLY_SHARE * period_s <= now_s - before_s <= LATE_SHARE * period_s
        return now_s - self._delay_s if in_rhythm and arrival.waited_s > AT_ONCE_S else None


class CameraClock:
    """Moments by the camera's own wall clock, which a time server keeps in step with this machine's."""

    def __init__(self) -> None:
        self._first_s: float | None = None

    def moment_s(self, arrival: Arrival) -> float | None:
        """Monotonic moment of exposure; raises `CameraError` when the camera does not send its time."""
        self._first_s = arrival.arrived_s if self._first_s is None else self._first_s
        if arrival.camera_utc_s is not None:
            return arrival.arrived_s - (arrival.arrived_utc_s - arrival.camera_utc_s)
        if arrival.arrived_s - self._first_s > CAMERA_TIME_WITHIN_S:
            raise CameraError(
                "sends no time of its own (RTCP sender reports); set clock = 'arrival'", "camera_clock_wrong"
            )
        return None
