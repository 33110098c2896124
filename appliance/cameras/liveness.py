"""Whether the pictures of a source show the line as it is now. Pure: the moment is given, nothing is waited for.

A picture counts only when it cannot be the one before: its content differs, and its device time stamp is later. What
does not count is not measured, so no reading is younger than what it shows. Only differences of monotonic moments and
of device time stamps are looked at; the wall clock may be set at any time.

Pictures of a recording or of the simulated mill are numbered by us: their first counts at once, and the same picture
again in another lap of a loop is no frozen camera, for the source says so (`Exposure.repeated`). A recording that
holds frozen, blank or out-of-step pictures is treated like the camera that made it.
"""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from appliance.cameras.settings import LivenessSettings
from appliance.cameras.source import Frame, FramePair

Picture = NDArray[np.uint8]

SIDES = ("left", "right")
CLOCK_TOLERANCE_S = 0.05  # an exposure that is said to be later than now by more than this
SAMPLE_STEP = 16  # pixels between those that are looked at first
HOT_PIXEL_SHARE = 0.001  # of the pixels of a blank picture may differ from the others, as hot pixels do
RATE_WINDOW_S = 5.0


class Exposure(NamedTuple):
    """What one exposure of one camera or of two gave.

    Attributes
    ----------
    pictures : tuple of ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        One for each camera, left first.
    device_us : tuple of int
        Device time stamps, µs, on one clock for all cameras; as many, or none where the source has none.
    exposed_monotonic_s : float
        Moment of exposure.
    dropped : int
        Exposures discarded since the source was opened.
    repeated : bool
        Whether the source knows that it shows the same stored pictures again.
    """

    pictures: tuple[Picture, ...]
    device_us: tuple[int, ...]
    exposed_monotonic_s: float
    dropped: int
    repeated: bool

    @classmethod
    def from_source(cls, exposed: FramePair | Frame) -> Self:
        """The exposure that a pair is, or a picture of a single camera."""
        if isinstance(exposed, FramePair):
            pictures, stamps = (exposed.left, exposed.right), (exposed.left_us, exposed.right_us)
        else:
            pictures = (exposed.picture,)
            stamps = () if exposed.device_us is None else (exposed.device_us,)
        return cls(pictures, stamps, exposed.exposed_monotonic_s, exposed.dropped, exposed.repeated)


class Verdict(NamedTuple):
    """What is to be thought of an exposure.

    Attributes
    ----------
    counts : bool
        Whether it may be measured.
    faults : dict of str to str
        Faults that are there now, by name, with what exactly is wrong. With an exposure that counts, only those
        that leave its value standing.
    lost_s : float
        Time since the last exposure that counted.
    """

    counts: bool
    faults: dict[str, str]
    lost_s: float


class Trouble(NamedTuple):
    """Why an exposure does not count: the fault that this becomes when it lasts (empty for none), and what is wrong."""

    fault: str
    detail: str


UNCONFIRMED_PICTURE = Trouble("", "the first picture, with which the next one is compared")
NO_PICTURE = Trouble("camera_lost", "no picture")


class Liveness:
    """Looks at every exposure of a source from its opening on.

    Parameters
    ----------
    settings : LivenessSettings
    opened_s : float
        Moment (monotonic) from which pictures can come.
    numbered : bool
        Whether the pictures are numbered by us (recording, mill), so that the first one counts.
    """

    def __init__(self, settings: LivenessSettings, opened_s: float, *, numbered: bool) -> None:
        self._settings = settings
        self._numbered = numbered
        self._before: Exposure | None = None
        self._seen_s = self._counted_s = opened_s
        self._trouble = NO_PICTURE
        self._rate = _Rate(settings, opened_s)

    def judge(self, exposure: Exposure | None, now_s: float) -> Verdict:
        """Judge the newest exposure, or that there is none.

        Parameters
        ----------
        exposure : Exposure or None
        now_s : float
            Monotonic time, not earlier than the one before.
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
        # pictures that differ nearly always do so in the sample, which spares reading all of them
        if np.array_equal(picture[::SAMPLE_STEP], earlier[::SAMPLE_STEP]) and np.array_equal(picture, earlier):
            return Trouble("camera_frozen", f"the {side} camera's picture does not change")
    return None


class _Rate:
    """Rate and losses of the exposures that count, judged over one stretch of time after the other."""

    def __init__(self, settings: LivenessSettings, opened_s: float) -> None:
        self._settings = settings
        self._faults: dict[str, str] = {}
        self._begin(opened_s, dropped=0)

    def add(self, exposure: Exposure, now_s: float) -> dict[str, str]:
        """Faults of the last whole stretch of time."""
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
