"""Exposures of the configured cameras that are believed as the gauge would believe them."""

import time
from collections.abc import Generator

from appliance.cameras.liveness import Exposure, Liveness
from appliance.cameras.settings import LivenessSettings
from appliance.cameras.source import Frame, FramePair, PairSource, PictureSource
from appliance.capture.error import CaptureError

WAIT_S = 0.5


def believed(
    source: PairSource | PictureSource, settings: LivenessSettings, within_s: float
) -> Generator[FramePair | Frame]:
    """Exposures of an opened source, for at most `within_s`; frozen, blank and out-of-step ones are left out.

    Parameters
    ----------
    source : PairSource or PictureSource
    settings : LivenessSettings
    within_s : float
        Seconds.

    Raises
    ------
    CaptureError
        The whole time there was none to believe; the sentence says why.
    CameraError
        A camera is lost.
    """
    until_s = time.monotonic() + within_s
    liveness = Liveness(settings, time.monotonic(), numbered=source.simulated)
    trouble, any_believed = "no picture came", False
    while (left_s := until_s - time.monotonic()) > 0:
        exposed = source.next(min(WAIT_S, left_s))
        verdict = liveness.judge(None if exposed is None else Exposure.from_source(exposed), time.monotonic())
        if exposed is not None and verdict.counts:
            any_believed = True
            yield exposed
        trouble = next(iter(verdict.faults.values()), trouble)
    if not any_believed:
        raise CaptureError(f"no picture to be used within {within_s:g} s: {trouble}; `hotgauge doctor` says more")
