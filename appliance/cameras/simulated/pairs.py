"""The simulated mill as a camera."""

import collections
import contextlib
import json
import math
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from appliance.cameras.pacing import Pacer, device_us, utc_ms
from appliance.cameras.source import CameraError, Frame, FramePair
from appliance.simulation.boards.boards import Board, BoardCorners, observe
from appliance.simulation.renderer_process import slots_of
from appliance.simulation.response import Response
from appliance.simulation.sensor import Sensor
from appliance.simulation.true_rig import default_rig

Picture = NDArray[np.uint8]
Drawn = tuple[int, Picture, Picture, dict[str, object], float]  # frame, left, right, truth, range

EXPOSURE_US = 500.0
PRINT_STREAM, DETECTOR_STREAM = 1, 2  # of random numbers: a board's errors know nothing of its pictures' noise
SLOTS = 12  # pairs prepared ahead
START_TIME_S = 30.0  # what stands still is drawn first
FRAME_TIME_S = 0.5  # of a pair, on a very busy computer


class MillSource:
    """Image pairs of the simulated mill in real time; see `PairSource`. A process of its own draws them ahead.

    Parameters
    ----------
    seed : int
        Bars, background and noise; the same seed gives the same pictures, frame by frame.
    rate_hz : float
        Exposures per second; 0 delivers every frame as fast as it is asked for. When drawing is slower, pairs are
        left out and counted as dropped.
    prepared_frames : int
        Frames that are drawn before the start and then played as a loop, at any rate; 0 draws as it goes.

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

    def __init__(self, seed: int, rate_hz: float, prepared_frames: int = 0) -> None:
        self._seed = seed
        self._rate_hz = rate_hz
        self._prepared_frames = prepared_frames
        self._rig = default_rig()
        self.board = Board.with_errors(np.random.default_rng([seed, PRINT_STREAM]))
        self.response: Response = Sensor().response
        self.image_size = self._rig.left.image_size

    def __enter__(self) -> Self:
        """Start drawing, wait until the ring is full, then start the clock; raises `CameraError`."""
        self._renderer = _Renderer(self._seed, self.image_size, self._prepared_frames or SLOTS)
        try:
            self._renderer.fill(START_TIME_S + FRAME_TIME_S * self._prepared_frames)
        except CameraError:
            self._renderer.close()
            raise
        self._last = -1
        self._dropped = 0
        self._start_s = time.monotonic()
        return self

    def __exit__(self, *_: object) -> None:
        """End the drawing process."""
        self._renderer.close()

    def next(self, timeout_s: float) -> FramePair | None:
        """Newest pair that is due, with the scene's truth; None when none is due and drawn in time.

        Raises
        ------
        CameraError
            The process that draws the pictures has ended.
        """
        until_s = time.monotonic() + timeout_s
        while (drawn := self._drawn(self._newest_due())) is None:
            left_s = until_s - time.monotonic()
            if left_s <= 0:
                return None
            self._renderer.receive(min(left_s, self._until_due_s()))
        return self._pair(*drawn)

    def _drawn(self, latest: int) -> Drawn | None:
        if not self._prepared_frames:
            return self._renderer.take(latest)
        return self._renderer.look(latest) if latest > self._last else None

    def _newest_due(self) -> int:
        if self._rate_hz == 0:
            return self._last + 1
        return int((time.monotonic() - self._start_s) * self._rate_hz)

    def _until_due_s(self) -> float:
        """Time until the next exposure, at most; a pair that is drawn too late comes as soon as it is drawn."""
        if self._rate_hz == 0:
            return math.inf
        return max(0.001, self._moment_s(self._newest_due() + 1) - time.monotonic())

    def _moment_s(self, frame: int) -> float:
        return time.monotonic() if self._rate_hz == 0 else self._start_s + frame / self._rate_hz

    def _pair(self, frame: int, left: Picture, right: Picture, truth: dict[str, object], range_mm: float) -> FramePair:
        self._dropped += frame - self._last - 1
        same_slot = self._prepared_frames > 0 and (frame - self._last) % self._prepared_frames == 0
        repeated = same_slot and self._last >= 0
        self._last = frame
        stamp_us = device_us(frame, self._rate_hz)
        moment_s = self._moment_s(frame)
        return FramePair(
            left,
            right,
            sequence=frame,
            left_us=stamp_us,
            right_us=stamp_us,
            exposed_monotonic_s=moment_s,
            exposed_utc_ms=utc_ms(moment_s),
            exposure_us=EXPOSURE_US,
            dropped=self._dropped,
            repeated=repeated,
            stamped=True,
            truth=truth,
            range_mm=range_mm,
        )

    def observe_boards(self) -> BoardCorners:
        """Corners that a detector finds on this mill's boards, for the station's own calibration at start."""
        return observe(self._rig, np.random.default_rng([self._seed, DETECTOR_STREAM]), self.board)


def drawn_frame(
    pacer: Pacer, timeout_s: float, draw: Callable[[int], tuple[Picture, dict[str, object]]]
) -> Frame | None:
    """Newest picture that is due, drawn by its number with its truth; None when none is due in time."""
    due = pacer.next_due(timeout_s)
    if due is None:
        return None
    number, moment_s = due
    picture, truth = draw(number)
    return Frame(
        picture,
        sequence=number,
        exposed_monotonic_s=moment_s,
        exposed_utc_ms=utc_ms(moment_s),
        exposure_us=EXPOSURE_US,
        dropped=pacer.dropped,
        truth=truth,
    )


class _Renderer:
    """The drawing process and the ring of pairs that it has drawn."""

    def __init__(self, seed: int, image_size: tuple[int, int], slots: int) -> None:
        columns, rows = image_size
        self._slots = slots
        self._link, theirs = socket.socketpair()
        ring = os.memfd_create("hotgauge-mill")
        os.ftruncate(ring, slots * 2 * rows * columns * 3)
        self._ring = slots_of(ring, slots, image_size)
        numbers = [str(number) for number in (theirs.fileno(), ring, slots, seed)]
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "appliance.simulation.renderer_process", *numbers],
            stdin=subprocess.DEVNULL,
            pass_fds=(theirs.fileno(), ring),
        )
        theirs.close()
        os.close(ring)
        self._rest = b""
        self._drawn: collections.deque[dict[str, Any]] = collections.deque()

    def fill(self, timeout_s: float) -> None:
        """Have every slot drawn; raises `CameraError` when that takes too long."""
        for slot in range(self._slots):
            self._free(slot, wanted=0)
        until_s = time.monotonic() + timeout_s
        while len(self._drawn) < self._slots:
            if time.monotonic() > until_s:
                raise CameraError("the simulated mill does not draw its pictures in time; the computer is overloaded")
            self.receive(1.0)

    def look(self, number: int) -> Drawn:
        """A frame of the loop that the slots hold, by its number in an endless line of loops."""
        drawn = self._drawn[number % self._slots]
        left, right = self._ring[drawn["slot"]].copy()
        return number, left, right, drawn["truth"], drawn["range_mm"]

    def receive(self, timeout_s: float) -> None:
        """Wait for news of drawn pairs; raises `CameraError` when the process has ended."""
        self._link.settimeout(None if timeout_s == math.inf else timeout_s)
        try:
            received = self._link.recv(1 << 16)
        except TimeoutError:
            return
        except ConnectionResetError:
            received = b""
        if not received:
            raise CameraError("the process that draws the simulated mill has ended; it is started again")
        *lines, self._rest = (self._rest + received).split(b"\n")
        self._drawn.extend(json.loads(line) for line in lines)

    def take(self, latest: int) -> Drawn | None:
        """Newest drawn frame up to a number, with its pictures and truth; older ones are let go."""
        newest = None
        while self._drawn and self._drawn[0]["frame"] <= latest:
            if newest is not None:
                self._free(newest["slot"], wanted=latest + 1)
            newest = self._drawn.popleft()
        if newest is None:
            return None
        left, right = self._ring[newest["slot"]].copy()
        self._free(newest["slot"], wanted=latest + 1)
        return newest["frame"], left, right, newest["truth"], newest["range_mm"]

    def _free(self, slot: int, wanted: int) -> None:
        with contextlib.suppress(OSError):  # that the process has ended is told when its news are read
            self._link.sendall(f"{slot} {wanted}\n".encode())

    def close(self) -> None:
        """End the process."""
        self._link.close()
        self._process.kill()
        self._process.wait()
