"""Judges whether the pictures of a camera show the line as it is now. Pure: the caller gives the moment.

A picture counts if its content differs from the one before and its device time stamp is later. Only pictures that
count are measured, so a reading is never younger than the light it was made of. Only differences of monotonic moments
and of device time stamps are compared; setting the wall clock changes nothing.

Pictures of a recording or of the simulated mill are numbered by the appliance: the first one counts at once, and the
same picture in the next lap of a loop (`Exposure.repeated`) is no frozen camera. A recording with frozen, blank or
out-of-step pictures is judged like the camera that made it.
"""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from appliance.cameras.settings import LivenessSettings
from appliance.cameras.source import Frame, FramePair

Picture = NDArray[np.uint8]

SIDES = ("left", "right")
CLOCK_TOLERANCE_S = 0.05  # chosen: an exposure further in the future than this shows a wrong camera clock
SAMPLE_STEP = (
    16  # chosen, pixels: every 16th row is compared before the whole picture; every 16th pixel tests for blank
)
HOT_PIXEL_SHARE = 0.001  # chosen: a picture stays blank if fewer of its pixels differ from the median, as hot pixels do
RATE_WINDOW_S = 5.0  # chosen: rate and losses are judged once in this time


class Exposure(NamedTuple):
    """Pictures, time stamps and counts of one exposure of one camera or of two.

    Attributes
    ----------
    pictures : tuple of ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        One for each camera, left first.
    device_us : tuple of int
        Device time stamps, µs, on one clock for all cameras, one for each picture; empty if the camera has none.
    exposed_monotonic_s : float
        Moment of exposure on the monotonic clock.
    dropped : int
        Exposures discarded since the camera was opened.
    repeated : bool
        Whether a recording shows the same stored pictures as before.
    """

    pictures: tuple[Picture, ...]
    device_us: tuple[int, ...]
    exposed_monotonic_s: float
    dropped: int
    repeated: bool

    @classmethod
    def from_source(cls, exposed: FramePair | Frame) -> Self:
        """Take over a pair, or a frame of a single camera."""
        if isinstance(exposed, FramePair):
            pictures, stamps = (exposed.left, exposed.right), (exposed.left_us, exposed.right_us)
        else:
            pictures = (exposed.picture,)
            stamps = () if exposed.device_us is None else (exposed.device_us,)
        return cls(pictures, stamps, exposed.exposed_monotonic_s, exposed.dropped, exposed.repeated)


class Verdict(NamedTuple):
    """Judgement of one exposure, or of its absence.

    Attributes
    ----------
    counts : bool
        Whether it may be measured.
    faults : dict of str to str
        Active faults by name, each with its detail. For an exposure that counts these are `pairs_slow` and
        `pairs_dropped`, with which its value is still served.
    lost_s : float
        Time since the last exposure that counted, seconds.
    """

    counts: bool
    faults: dict[str, str]
    lost_s: float


class Trouble(NamedTuple):
    """Why an exposure does not count: the fault after `lost_after_ms` (empty: none), and its detail."""

    fault: str
    detail: str


UNCONFIRMED_PICTURE = Trouble("", "the first picture, with which the next one is compared")
NO_PICTURE = Trouble("camera_lost", "no picture")


class Liveness:
    """Judges every exposure of a camera from its opening on.

    Parameters
    ----------
    settings : LivenessSettings
    opened_s : float
        Monotonic moment at which the camera was opened.
    numbered : bool
        Whether the appliance numbers the pictures (recording, mill), so that the first one counts.
    """

    def __init__(self, settings: LivenessSettings, opened_s: float, *, numbered: bool) -> None:
        self._settings = settings
        self._numbered = numbered
        self._before: Exposure | None = None
        self._seen_s = self._counted_s = opened_s
        self._trouble = NO_PICTURE
        self._rate = _Rate(settings, opened_s)

    def judge(self, exposure: Exposure | None, now_s: float) -> Verdict:
        """Judge the newest exposure, or its absence.

        Parameters
        ----------
        exposure : Exposure or None
            None if none came in time.
        now_s : float
            Monotonic time, not earlier than in the call before.
        """
        if exposure is not None:
            trouble = self._trouble_of(exposure, now_s)
            self._before = exposure
            self._seen_s = now_s
            if trouble is None:
                self._counted_s = now_s
                return Verdict(counts=True, faults=self._rate.add(exposure, now_s), lost_s=0.0)
            self._trouble = trouble
        elif self._is_long(now_s - self._seen_s):
            self._trouble = NO_PICTURE
        return self._lost(now_s - self._counted_s)

    def _lost(self, lost_s: float) -> Verdict:
        fault, detail = self._trouble
        faults = {fault: f"{detail}, for {lost_s:.1f} s"} if fault and self._is_long(lost_s) else {}
        return Verdict(counts=False, faults=faults, lost_s=lost_s)

    def _is_long(self, seconds: float) -> bool:
        return 1000 * seconds >= self._settings.lost_after_ms

    def _trouble_of(self, exposure: Exposure, now_s: float) -> Trouble | None:
        apart = _apart(exposure, self._settings.apart_max_us)
        blank = _blank(exposure, self._settings.blank_level)
        future = _future(exposure, now_s)
        if self._before is None:
            return future or apart or blank or (None if self._numbered else UNCONFIRMED_PICTURE)
        return (
            _size_changed(exposure, self._before)
            or future
            or _clock(exposure, self._before)
            or apart
            or blank
            or _frozen(exposure, self._before)
        )


def _size_changed(exposure: Exposure, before: Exposure) -> Trouble | None:
    for side, picture, earlier in zip(SIDES, exposure.pictures, before.pictures, strict=False):
        if picture.shape != earlier.shape:
            was, now = (f"{columns} x {rows}" for rows, columns in (earlier.shape[:2], picture.shape[:2]))
            return Trouble("picture_size_changed", f"the {side} camera's pictures were {was} pixels and are {now}")
    return None


def _future(exposure: Exposure, now_s: float) -> Trouble | None:
    if exposure.exposed_monotonic_s > now_s + CLOCK_TOLERANCE_S:
        return Trouble("camera_clock_wrong", "the moment of exposure is later than now")
    return None


def _clock(exposure: Exposure, before: Exposure) -> Trouble | None:
    if exposure.exposed_monotonic_s < before.exposed_monotonic_s:
        return Trouble("camera_clock_wrong", "the moment of exposure is earlier than the one before")
    for side, stamp_us, earlier_us in zip(SIDES, exposure.device_us, before.device_us, strict=False):
        if stamp_us == earlier_us:
            return Trouble("camera_frozen", f"the {side} camera's time stamp stands still")
        if stamp_us < earlier_us:
            return Trouble("camera_clock_wrong", f"the {side} camera's time stamp goes back")
    return None


def _apart(exposure: Exposure, apart_max_us: int) -> Trouble | None:
    apart_us = max(exposure.device_us, default=0) - min(exposure.device_us, default=0)
    if apart_us <= apart_max_us:
        return None
    return Trouble("pair_out_of_step", f"left and right were exposed {apart_us} µs apart, at most {apart_max_us}")


def _blank(exposure: Exposure, level: int) -> Trouble | None:
    for side, picture in zip(SIDES, exposure.pictures, strict=False):
        sample = picture[::SAMPLE_STEP, ::SAMPLE_STEP].astype(np.int16)
        middle = np.median(sample, axis=(0, 1))
        if np.mean(np.abs(sample - middle) > level) < HOT_PIXEL_SHARE:
            return Trouble("picture_blank", f"the {side} camera's picture is {np.mean(middle):.0f} all over")
    return None


def _frozen(exposure: Exposure, before: Exposure) -> Trouble | None:
    if exposure.repeated:
        return None
    for side, picture, earlier in zip(SIDES, exposure.pictures, before.pictures, strict=False):
        # the sample already differs in nearly all live pictures, so the whole is rarely compared
        if np.array_equal(picture[::SAMPLE_STEP], earlier[::SAMPLE_STEP]) and np.array_equal(picture, earlier):
            return Trouble("camera_frozen", f"the {side} camera's picture does not change")
    return None


class _Rate:
    """Rate and losses of the exposures that count, judged in windows of RATE_WINDOW_S, one after the other."""

    def __init__(self, settings: LivenessSettings, opened_s: float) -> None:
        self._settings = settings
        self._faults: dict[str, str] = {}
        self._begin(opened_s, dropped=0)

    def add(self, exposure: Exposure, now_s: float) -> dict[str, str]:
        """Count an exposure and return the faults of the last complete window."""
        self._count += 1
        elapsed_s = now_s - self._began_s
        if elapsed_s >= RATE_WINDOW_S:
            self._faults = self._judge(1000 * elapsed_s / self._count, exposure.dropped - self._dropped)
            self._begin(now_s, exposure.dropped)
        return dict(self._faults)

    def _begin(self, now_s: float, dropped: int) -> None:
        self._began_s = now_s
        self._dropped = dropped
        self._count = 0

    def _judge(self, interval_ms: float, dropped: int) -> dict[str, str]:
        faults: dict[str, str] = {}
        if interval_ms > self._settings.interval_max_ms:
            faults["pairs_slow"] = f"one every {interval_ms:.0f} ms, wanted {self._settings.interval_max_ms} at most"
        lost_percent = 100 * dropped / (dropped + self._count)
        if lost_percent > self._settings.dropped_max_percent:
            faults["pairs_dropped"] = f"{lost_percent:.0f} % lost, {self._settings.dropped_max_percent:g} % at most"
        return faults
