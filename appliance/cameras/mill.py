"""The simulated mill as a camera."""

from typing import Self

import numpy as np

from appliance.cameras.pacing import Pacer, device_us, utc_ms
from appliance.cameras.source import FramePair
from appliance.mill.bars import bar_at, truth
from appliance.mill.boards import Board, BoardCorners, observe
from appliance.mill.rig import default_rig
from appliance.mill.scene import Scene
from appliance.mill.sensor import Response, Sensor

EXPOSURE_US = 500.0
PRINT_STREAM, DETECTOR_STREAM = 1, 2  # of random numbers: a board's errors know nothing of its pictures' noise


class MillSource:
    """Image pairs of the simulated mill in real time; see `PairSource`. Each is drawn when it is asked for.

    Parameters
    ----------
    seed : int
        Bars, background and noise; the same seed gives the same pictures, frame by frame.
    rate_hz : float
        Exposures per second; 0 draws every frame as fast as it is asked for.

    Attributes
    ----------
    board : Board
        Checkerboard of this mill, with its hidden errors.
    response : str
        How pixel values follow from light.
    image_size : tuple of int
        (columns, rows), pixels.
    """

    simulated = True

    def __init__(self, seed: int, rate_hz: float) -> None:
        self._seed = seed
        self._rate_hz = rate_hz
        self._rig = default_rig()
        self._sensor = Sensor()
        self.board = Board.with_errors(np.random.default_rng([seed, PRINT_STREAM]))
        self.response: Response = self._sensor.response
        self.image_size = self._rig.left.image_size

    def __enter__(self) -> Self:
        """Draw what stands still, then start the clock."""
        self._scene = Scene(self._rig, self._seed, self._sensor)
        self._pacer = Pacer(self._rate_hz)
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing to release."""

    def next(self, timeout_s: float) -> FramePair | None:
        """Newest pair that is due, with the scene's truth; None when none is due in time."""
        due = self._pacer.take(timeout_s)
        if due is None:
            return None
        sequence, moment_s = due
        bar = bar_at(self._seed, sequence)
        left, right = self._scene.pair(bar, sequence)
        stamp_us = device_us(sequence, self._rate_hz)
        return FramePair(
            left,
            right,
            sequence=sequence,
            left_us=stamp_us,
            right_us=stamp_us,
            exposed_monotonic_s=moment_s,
            exposed_utc_ms=utc_ms(moment_s),
            exposure_us=EXPOSURE_US,
            dropped=self._pacer.dropped,
            truth=truth(bar),
        )

    def observe_boards(self) -> BoardCorners:
        """Corners that a detector finds on this mill's boards, for the station's own calibration at start."""
        return observe(self._rig, np.random.default_rng([self._seed, DETECTOR_STREAM]), self.board)
