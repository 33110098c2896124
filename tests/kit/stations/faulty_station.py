"""The real measuring loop with a camera and a gauge that do what the file named by FAKE_STATION says."""

import ctypes
import os
import time
from pathlib import Path
from typing import Self

import numpy as np

from appliance.cameras.pacing import Pacer, utc_ms
from appliance.cameras.source import CameraError, FramePair
from appliance.sizing import station as sizing
from appliance.sizing.stereo.settings import SizingSettings
from vision.readings import SizeReading

RATE_HZ = 20.0
SHAPE = (60, 80)


def told() -> str:
    return Path(os.environ["FAKE_STATION"]).read_text(encoding="utf-8")


class ToldCamera:
    simulated = False  # so that it is believed no more than a camera is

    def __enter__(self) -> Self:
        if told() == "unplugged":
            raise CameraError("no camera is connected; check the cable")
        self._pacer = Pacer(RATE_HZ)
        self._left = None
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def next(self, timeout_s: float) -> FramePair | None:
        due = self._pacer.next_due(timeout_s)
        mode = told()
        if mode == "unplugged":
            raise CameraError("the camera does not answer any more; check the cable")
        if mode == "silent":
            time.sleep(timeout_s)
            return None
        return None if due is None else self._pair(*due, mode)

    def _pair(self, sequence: int, moment_s: float, mode: str) -> FramePair:
        left, right = (np.random.default_rng([sequence, side]).integers(0, 200, SHAPE, np.uint8) for side in (0, 1))
        left_us = right_us = round(1e6 * moment_s)
        if mode == "frozen":
            left = left if self._left is None else self._left
        elif mode == "time stamps stand still":
            left_us = right_us = 1
        elif mode == "out of step":
            right_us += 1_000_000
        elif mode == "black":
            right = np.zeros(SHAPE, np.uint8)
        elif mode == "wrong size":
            right = right[: SHAPE[0] // 2 + sequence % 2]
        elif mode == "clock a day ahead":
            moment_s += 86_400
        self._left = left
        return FramePair(
            left, right, sequence=sequence, left_us=left_us, right_us=right_us,
            exposed_monotonic_s=moment_s, exposed_utc_ms=utc_ms(moment_s), dropped=self._pacer.dropped,
        )  # fmt: skip


class ToldGauge:
    scale_files = ()
    carried = ()

    def warm_up(self) -> None:
        pass

    def lines(self, _: SizeReading) -> list[list]:
        return [[], []]

    def measure_exposed(self, exposed: FramePair) -> tuple[tuple[SizeReading, ...], float]:
        mode = told()
        if mode == "native crash":
            ctypes.string_at(0)
        elif mode == "too much memory":
            hoard = []
            while True:
                hoard.append(np.ones(1 << 24))
        elif mode == "error":
            raise ArithmeticError("as told")
        elif mode == "hang":
            time.sleep(3600)
        diameter_mm = 200 + float(exposed.left[0, 0]) / 100
        reading = SizeReading(diameter_mm=diameter_mm, expanded_uncertainty_mm=0.2, windows_kept=20, windows_total=25)
        return (reading,), 1.0


if __name__ == "__main__":
    SizingSettings.make_source = lambda _: ToldCamera()
    SizingSettings.make_gauge = lambda *_: ToldGauge()
    sizing.main()
