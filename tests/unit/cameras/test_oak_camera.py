"""OAK cameras without hardware: the same pipeline code, fed by depthai's host nodes from a recording."""

import threading
import time
from dataclasses import replace
from datetime import timedelta

import depthai as dai
import numpy as np
import pytest

from appliance.cameras.liveness import Exposure, Liveness
from appliance.cameras.oak.settings import OakCamera, OakPictures
from appliance.cameras.oak.source import Cameras, OakPictureSource, OakSource, picture_of_frame
from appliance.cameras.settings import LivenessSettings
from appliance.cameras.source import CameraError

RAMP = 3 * np.arange(60 * 80).reshape(60, 80)  # a picture of one grey would be taken for a covered lens


class Player(dai.node.ThreadedHostNode):
    """Plays pictures whose first pixel is their number, stamped with the moments of a true shutter."""

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
            frame.setCvFrame(((number + RAMP) % 256).astype(np.uint8), dai.ImgFrame.Type.GRAY8)
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


def source(bench, in_step_us=1000):
    return OakSource(OakCamera(kind="oak"), in_step_us, bench)


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
    assert all((pair.left == pair.right).all() for pair in pairs)
    assert all(pair.left_us == pair.right_us for pair in pairs)
    numbers = [pair.sequence for pair in pairs]
    assert numbers == sorted(set(numbers))
    assert pairs[-1].dropped == pairs[-1].sequence + 1 - len(pairs)
    assert all(abs(time.monotonic() - pair.exposed_monotonic_s) < 60 for pair in pairs)


def test_at_full_speed_no_pair_is_mixed():
    flat_out = {"period_s": 1e-3, "frames": 1500}
    with source(Bench(left=flat_out, right=flat_out), in_step_us=50000) as oak:
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


def judged(oak, seconds):
    """Every verdict over the pairs of some seconds, as the station asks for it."""
    liveness = Liveness(LivenessSettings(), time.monotonic(), numbered=False)
    until = time.monotonic() + seconds
    verdicts = []
    while time.monotonic() < until:
        pair = oak.next(0.2)
        verdicts.append(liveness.judge(pair and Exposure.from_source(pair), time.monotonic()))
    return verdicts


def test_cameras_out_of_step_never_count_and_are_called_so():
    late = {"frames": 250, "period_s": 0.02, "late_s": 0.008}
    with source(Bench(same_device=False, left={"frames": 250, "period_s": 0.02}, right=late)) as oak:
        verdicts = judged(oak, 2.0)
    assert not any(verdict.counts for verdict in verdicts)
    assert "pair_out_of_step" in verdicts[-1].faults


def test_cameras_in_step_count():
    with source(Bench(same_device=False)) as oak:
        verdicts = judged(oak, 1.0)
    assert sum(verdict.counts for verdict in verdicts) > 20


def test_cameras_that_fall_silent_are_lost():
    with source(Bench(left={"frames": 20}, right={"frames": 20})) as oak:
        verdicts = judged(oak, 2.0)
    assert not verdicts[-1].counts
    assert "camera_lost" in verdicts[-1].faults


def test_a_pipeline_that_ends_is_a_lost_camera():
    with source(Bench()) as oak:
        pairs_of(oak, 5)
        oak._open._pipeline.stop()
        with pytest.raises(CameraError, match="gone"):
            play(oak)


def test_it_can_be_opened_again_after_a_loss():
    for _ in range(3):
        with source(Bench()) as oak:
            assert pairs_of(oak, 3)


def test_without_a_device_it_says_what_to_check_and_at_once():
    started = time.monotonic()
    with pytest.raises(CameraError, match="check cable and power"), OakSource(OakCamera(kind="oak"), 1000):
        pass
    assert time.monotonic() - started < 8


def test_a_single_sensor_gives_the_newest_picture_and_counts_what_was_left_out():
    def one(pipeline, _):
        player = pipeline.create(Player)
        player.prepare(time.monotonic() + 0.05, period_s=0.01, frames=300)
        return Cameras((player.output,), same_device=True)

    with OakPictureSource(OakPictures(kind="oak"), one) as oak:
        first = oak.next(1.0)
        time.sleep(0.3)
        later = oak.next(1.0)
    assert (later.picture != first.picture).any()
    assert later.sequence > first.sequence + 10
    assert later.dropped == later.sequence - 1
    assert later.device_us > first.device_us


def test_an_exposure_that_reaches_a_lost_camera_is_no_crash():
    class Lost:
        def send(self, _):
            raise RuntimeError("Communication exception: X_LINK_ERROR")

    def cameras(pipeline, more):
        return replace(Bench()(pipeline, more), controls=(Lost(), Lost()))

    with OakSource(OakCamera(kind="oak"), 1000, cameras) as oak:
        oak.set_exposure(500.0)


def test_of_nv12_the_luma_is_measured_as_it_was_sent_and_colours_are_shown():
    """Luma of a picture whose colours change from pixel to pixel: made of the decoded colours it would be smoothed."""
    bgr = np.random.default_rng(2).integers(0, 256, (48, 64, 3), dtype=np.uint8)
    frame = dai.ImgFrame()
    frame.setCvFrame(bgr, dai.ImgFrame.Type.NV12)
    picture = picture_of_frame(frame)
    weights = np.array([24.966, 128.553, 65.481]) / 255  # of blue, green, red in 16 to 235 (ITU-R BT.601)
    assert np.abs(picture.measured[:, :, 0] - (16 + bgr @ weights)).max() <= 1
    assert (picture.coding.samples, picture.coding.black, picture.coding.white) == ("luma", 16, 235)
    assert picture.shown.shape == (48, 64, 3)
