"""OAK cameras without hardware: the same pipeline code, fed by depthai's host nodes from a recording."""

import threading
import time
from datetime import timedelta

import depthai as dai
import numpy as np
import pytest

from appliance.cameras.oak import SILENT_S, Cameras, OakSource
from appliance.cameras.source import CameraError
from appliance.settings import OakCamera

SHAPE = (60, 80)


class Player(dai.node.ThreadedHostNode):
    """Plays pictures whose value is their number, stamped with the moments of a true shutter."""

    def __init__(self):
        super().__init__()
        self.output = self.createOutput()
        self.closed = threading.Event()

    def prepare(self, start, *, period_s, frames, late_s=0.0, without=(), first_sequence=0):
        self.start_s, self.period_s, self.frames, self.late_s = start, period_s, frames, late_s
        self.without, self.first_sequence = without, first_sequence

    def run(self):
        for number in range(self.frames):
            due = self.start_s + number * self.period_s
            while self.isRunning() and time.monotonic() < due and not self.closed.is_set():
                time.sleep(min(0.002, self.period_s / 2))
            if not self.isRunning() or self.closed.is_set():
                return
            if number in self.without:
                continue
            frame = dai.ImgFrame()
            frame.setCvFrame(np.full(SHAPE, number % 256, np.uint8), dai.ImgFrame.Type.GRAY8)
            frame.setSequenceNum(self.first_sequence + number)
            frame.setTimestamp(timedelta(seconds=due + self.late_s))
            frame.setTimestampDevice(timedelta(seconds=number * self.period_s + self.late_s))
            self.output.send(frame)


class Bench:
    """Both cameras of a test, and what becomes of them."""

    def __init__(self, *, same_device=True, left=None, right=None):
        self.same_device, self.left, self.right = same_device, left or {}, right or {}
        self.players = []

    def __call__(self, pipeline, _):
        start = time.monotonic() + 0.05
        for changes in (self.left, self.right):
            player = pipeline.create(Player)
            player.prepare(start, **({"period_s": 0.01, "frames": 200} | changes))
            self.players.append(player)
        return Cameras((self.players[0].output, self.players[1].output), same_device=self.same_device)


def source(bench, **settings):
    return OakSource(OakCamera(kind="oak", **settings), bench)


def pairs_of(oak, count):
    pairs = []
    while len(pairs) < count:
        pair = oak.next(1.0)
        if pair is not None:
            pairs.append(pair)
    return pairs


def play(oak):
    while True:
        oak.next(1.0)


def test_pairs_are_of_the_same_exposure_and_in_order():
    with source(Bench()) as oak:
        pairs = pairs_of(oak, 60)
    assert all((pair.left == pair.right[0, 0]).all() for pair in pairs)
    assert all(pair.left_us == pair.right_us for pair in pairs)
    numbers = [pair.sequence for pair in pairs]
    assert numbers == sorted(set(numbers))
    assert pairs[-1].dropped == pairs[-1].sequence + 1 - len(pairs)
    assert all(abs(time.monotonic() - pair.exposed_monotonic_s) < 60 for pair in pairs)


def test_at_full_speed_no_pair_is_mixed():
    flat_out = {"period_s": 1e-3, "frames": 1500}
    with source(Bench(left=flat_out, right=flat_out), apart_max_us=50000) as oak:
        pairs = []
        while pair := oak.next(0.5):
            pairs.append(pair)
    assert len(pairs) > 20
    assert all(pair.left[0, 0] == pair.right[0, 0] for pair in pairs)


def test_a_picture_that_one_sensor_lost_gives_no_pair_and_is_counted():
    lost = tuple(range(5, 15))
    with source(Bench(left={"frames": 30}, right={"frames": 30, "without": lost})) as oak:
        pairs = []
        while pair := oak.next(0.5):
            pairs.append(pair)
    assert not {pair.sequence for pair in pairs} & set(lost)
    assert all(pair.left[0, 0] == pair.right[0, 0] for pair in pairs)
    assert pairs[-1].dropped >= len(lost)


def test_two_devices_are_paired_by_time_though_they_count_differently():
    with source(Bench(same_device=False, right={"first_sequence": 700, "late_s": 0.0002})) as oak:
        pairs = pairs_of(oak, 30)
    assert all(pair.left[0, 0] == pair.right[0, 0] for pair in pairs)
    assert all(pair.right_us - pair.left_us == pytest.approx(200, abs=2) for pair in pairs)


def test_cameras_out_of_step_are_no_pair_and_said_so():
    with source(Bench(same_device=False, left={"frames": 600}, right={"frames": 600, "late_s": 0.004})) as oak:
        started = time.monotonic()
        with pytest.raises(CameraError, match="synchronises"):
            play(oak)
    assert SILENT_S <= time.monotonic() - started < SILENT_S + 5


def test_a_camera_that_falls_silent_is_lost():
    bench = Bench(left={"frames": 20}, right={"frames": 20})
    with source(bench) as oak:
        pairs_of(oak, 5)
        with pytest.raises(CameraError, match="sent no pair"):
            play(oak)


def test_a_pipeline_that_ends_is_a_lost_camera():
    with source(Bench()) as oak:
        pairs_of(oak, 5)
        oak._pipeline.stop()
        with pytest.raises(CameraError, match="gone"):
            play(oak)


def test_it_can_be_opened_again_after_a_loss():
    for _ in range(3):
        with source(Bench()) as oak:
            assert pairs_of(oak, 3)


def test_without_a_device_it_says_what_to_check_and_at_once():
    started = time.monotonic()
    with pytest.raises(CameraError, match="check cable and power"), OakSource(OakCamera(kind="oak")):
        pass
    assert time.monotonic() - started < 8
