"""Checkerboards before the cameras of the simulated mill, for trying `hotgauge capture`."""

import math
from typing import Literal, Self

import numpy as np

from appliance.cameras.pacing import Pacer, device_us, utc_ms
from appliance.cameras.simulated.pairs import EXPOSURE_US, PRINT_STREAM
from appliance.cameras.source import FramePair
from appliance.simulation.bars.line_scene import Scene, noise_starts
from appliance.simulation.boards.board_pictures import board_light
from appliance.simulation.boards.boards import Board, Pose, high_pose, low_pose, random_poses
from appliance.simulation.sensor import Light, Sensor
from appliance.simulation.true_rig import default_rig

HOLD_S = 1.5  # for which a board is held still
POSES = 40  # after which they come again
POSE_STREAM = 3  # of random numbers, beside those of the print and of the detector

Shown = Literal["boards", "low", "high"]


class MillBoardSource:
    """Image pairs of a board that is held still, then elsewhere; see `PairSource`.

    Parameters
    ----------
    seed : int
        Background, noise, the board's hidden errors and its poses.
    rate_hz : float
        Exposures per second.
    shown : {"boards", "low", "high"}
        Poses for the calibration of the cameras, or the board flat at one of both heights.
    """

    simulated = True

    def __init__(self, seed: int, rate_hz: float, shown: Shown) -> None:
        self._seed = seed
        self._rate_hz = rate_hz
        self._shown = shown

    def __enter__(self) -> Self:
        """Draw the line without a bar."""
        rig = default_rig()
        self._scene = Scene(rig, self._seed, Sensor())
        self._board = Board.with_errors(np.random.default_rng([self._seed, PRINT_STREAM]))
        self._poses = self._all_poses()
        self._delivered = 0
        self._drawn: tuple[int, tuple[Light, Light]] | None = None
        self._pacer = Pacer(self._rate_hz)
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is held open."""

    def next(self, timeout_s: float) -> FramePair | None:
        """Newest pair that is due; None when none is due in time."""
        due = self._pacer.next_due(timeout_s)
        if due is None:
            return None
        number, moment_s = due
        views = (self._scene.left, self._scene.right)
        left, right = (
            view.grey_picture(light, start)
            for view, light, start in zip(
                views, self._light(self._pose_now()), noise_starts(self._seed, number), strict=True
            )
        )
        self._delivered += 1
        stamp_us = device_us(number, self._rate_hz)
        return FramePair(
            left,
            right,
            sequence=number,
            left_us=stamp_us,
            right_us=stamp_us,
            exposed_monotonic_s=moment_s,
            exposed_utc_ms=utc_ms(moment_s),
            exposure_us=EXPOSURE_US,
            dropped=self._pacer.dropped,
        )

    def _all_poses(self) -> list[Pose]:
        if self._shown == "low":
            return [low_pose(self._board)]
        if self._shown == "high":
            return [high_pose(self._board)]
        return random_poses(default_rig(), np.random.default_rng([self._seed, POSE_STREAM]), self._board, POSES)

    def _pose_now(self) -> int:
        """Number of the pose; it counts what was delivered, since drawing another one takes its time."""
        return self._delivered // math.ceil(HOLD_S * self._rate_hz) % len(self._poses)

    def _light(self, number: int) -> tuple[Light, Light]:
        """Linear light of a pose in both pictures; drawn once while it is held."""
        if self._drawn is None or self._drawn[0] != number:
            views = (self._scene.left, self._scene.right)
            left, right = (board_light(view, self._board, self._poses[number]) for view in views)
            self._drawn = number, (left, right)
        return self._drawn[1]
