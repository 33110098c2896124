"""Each detector on exposures made for it, and on pictures that no detector may object to."""

import dataclasses
from collections.abc import Callable

import cv2
import numpy as np
import pytest

from appliance.cameras import liveness as liveness_module
from appliance.cameras.liveness import Exposure, Liveness
from appliance.cameras.recording.pairs import RecordingSource
from appliance.cameras.settings import LivenessSettings
from appliance.cameras.simulated.pairs import MillSource

PERIOD_S = 0.1
SETTINGS = LivenessSettings()


def pictures(number: int, *, shape: tuple[int, ...] = (60, 80)) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(number)
    return tuple(rng.integers(0, 255, shape, np.uint8) for _ in range(2))


def exposure(number: int, **changes) -> Exposure:
    stamp_us = round(number * PERIOD_S * 1e6)
    good = Exposure(pictures(number), (stamp_us, stamp_us), 100 + number * PERIOD_S, 0, repeated=False)
    return good._replace(**changes)


def first_fault(make: Callable[[int], Exposure | None], *, exposures: int = 30, settings=SETTINGS, numbered=False):
    """Name of the first fault, the time since all was well, and how many exposures counted after that."""
    liveness = Liveness(settings, 100.0, numbered=numbered)
    for number in range(10):
        liveness.judge(exposure(number), 100 + number * PERIOD_S)
    counted = 0
    for number in range(10, 10 + exposures):
        verdict = liveness.judge(make(number), 100 + number * PERIOD_S)
        counted += verdict.counts
        if verdict.faults:
            ((name, detail),) = verdict.faults.items()
            return name, (number - 9) * PERIOD_S, counted, detail
    return None, None, counted, ""


def frozen_left(number: int) -> Exposure:
    return exposure(number, pictures=(pictures(9)[0], pictures(number)[1]))


def frozen_right(number: int) -> Exposure:
    return exposure(number, pictures=(pictures(number)[0], pictures(9)[1]))


def standing_stamp(number: int) -> Exposure:
    return exposure(number, device_us=(900_000, 900_000))


def out_of_step(number: int) -> Exposure:
    left_us, _ = exposure(number).device_us
    return exposure(number, device_us=(left_us, left_us + SETTINGS.apart_max_us + 1))


def black(number: int) -> Exposure:
    noise = np.random.default_rng(number).integers(0, 3, (60, 80), np.uint8)
    return exposure(number, pictures=(pictures(number)[0], noise))


def green(number: int) -> Exposure:
    plain = np.full((600, 800, 3), (0, 135, 0), np.uint8)
    plain[0, 10 * number :][:5] = 255  # a clock burnt into the picture
    return exposure(number, pictures=(plain, pictures(number, shape=(600, 800, 3))[0]))


def another_size(number: int) -> Exposure:
    return exposure(number, pictures=(pictures(number)[0], pictures(number)[1][: 50 - number % 2]))


def clock_back(number: int) -> Exposure:
    stamp_us = 900_000 - number
    return exposure(number, device_us=(stamp_us, stamp_us))


def from_the_future(number: int) -> Exposure:
    return exposure(number, exposed_monotonic_s=100 + number * PERIOD_S + 86_400)


def nothing(_: int) -> None:
    return None


DETECTORS = [
    (frozen_left, "camera_frozen", "left camera's picture", "_frozen"),
    (frozen_right, "camera_frozen", "right camera's picture", "_frozen"),
    (standing_stamp, "camera_frozen", "left camera's time stamp", "_clock"),
    (out_of_step, "pair_out_of_step", "5001 µs", "_apart"),
    (black, "picture_blank", "right", "_blank"),
    (another_size, "picture_size_changed", "right", "_size_changed"),
    (clock_back, "camera_clock_wrong", "back", "_clock"),
    (from_the_future, "camera_clock_wrong", "later than now", "_future"),
]


@pytest.mark.parametrize(("make", "name", "words", "detector"), DETECTORS)
def test_what_may_not_be_believed_is_not_measured_and_named_in_time(make, name, words, detector):
    found, after_s, counted, detail = first_fault(make)
    assert found == name
    assert words in detail
    assert counted == 0
    limit_s = SETTINGS.lost_after_ms / 1000
    assert limit_s - 1e-6 <= after_s <= limit_s + PERIOD_S + 1e-6


@pytest.mark.parametrize(("make", "name", "words", "detector"), DETECTORS)
def test_a_faulty_camera_would_be_measured_without_its_detector(make, name, words, detector, monkeypatch):
    monkeypatch.setattr(liveness_module, detector, lambda *_: None)
    found, _, counted, _ = first_fault(make)
    assert found is None
    assert counted == 30


def test_a_camera_that_gives_nothing_is_lost_in_time():
    found, after_s, _, _ = first_fault(nothing)
    assert found == "camera_lost"
    assert after_s == pytest.approx(SETTINGS.lost_after_ms / 1000, abs=PERIOD_S + 1e-6)
    assert first_fault(nothing, settings=SETTINGS.model_copy(update={"lost_after_ms": 10000}))[0] is None


def test_a_picture_that_is_one_colour_with_a_moving_mark_is_blank():
    liveness = Liveness(SETTINGS, 100.0, numbered=True)
    verdicts = [liveness.judge(green(number), 100 + number * PERIOD_S) for number in range(10, 30)]
    assert not any(verdict.counts for verdict in verdicts)
    assert set(verdicts[-1].faults) == {"picture_blank"}


def test_good_pictures_are_no_fault_for_as_long_as_they_come():
    assert first_fault(exposure, exposures=600) == (None, None, 600, "")


def test_one_bad_exposure_costs_itself_and_no_fault():
    found, _, counted, _ = first_fault(lambda number: frozen_left(number) if number == 10 else exposure(number))
    assert found is None
    assert counted == 29


def test_a_fault_is_over_with_the_first_exposure_that_counts():
    liveness = Liveness(SETTINGS, 100.0, numbered=False)
    for number in range(10):
        liveness.judge(exposure(number), 100 + number * PERIOD_S)
    assert liveness.judge(None, 102.0).faults
    verdict = liveness.judge(exposure(21), 102.2)
    assert verdict.counts
    assert not verdict.faults


def test_the_first_picture_of_a_camera_waits_for_the_second_and_that_of_a_recording_does_not():
    camera, recording = (Liveness(SETTINGS, 100.0, numbered=numbered) for numbered in (False, True))
    assert not camera.judge(exposure(1), 100.1).counts
    assert camera.judge(exposure(2), 100.2).counts
    assert recording.judge(exposure(1), 100.1).counts


def test_a_frozen_camera_that_is_opened_again_never_counts():
    for _ in range(5):
        liveness = Liveness(SETTINGS, 100.0, numbered=False)
        assert not any(liveness.judge(frozen(number), 100 + number * PERIOD_S).counts for number in range(60))


def frozen(number: int) -> Exposure:
    return exposure(number, pictures=pictures(0))


def test_what_is_wrong_is_still_named_while_a_slow_camera_sends_nothing_in_between():
    def slow(number: int) -> Exposure | None:
        return frozen_left(number) if number % 4 == 0 else None

    assert first_fault(slow)[0] == "camera_frozen"


def test_pairs_that_are_late_or_lost_are_told_with_values_that_stand():
    liveness = Liveness(SETTINGS, 100.0, numbered=False)
    verdicts = [
        liveness.judge(exposure(6 * number, dropped=5 * number), 100 + 6 * number * PERIOD_S) for number in range(12)
    ]
    assert all(verdict.counts for verdict in verdicts[1:])
    assert set(verdicts[-1].faults) == {"pairs_slow", "pairs_dropped"}
    lenient = SETTINGS.model_copy(update={"interval_max_ms": 700, "dropped_max_percent": 90.0})
    liveness = Liveness(lenient, 100.0, numbered=False)
    for number in range(12):
        verdict = liveness.judge(exposure(6 * number, dropped=5 * number), 100 + 6 * number * PERIOD_S)
    assert verdict.faults == {}


def test_a_loop_that_repeats_is_no_frozen_camera(tmp_path):
    write_recording(tmp_path, count=1)
    with RecordingSource(tmp_path, rate_hz=0, loop=True) as source:
        liveness = Liveness(SETTINGS, 0.0, numbered=True)
        pairs = [source.next(1) for _ in range(20)]
        verdicts = [liveness.judge(Exposure.from_source(pair), pair.exposed_monotonic_s) for pair in pairs]
        assert all(verdict.counts for verdict in verdicts)
        told_wrongly = Exposure.from_source(
            dataclasses.replace(pairs[-1], repeated=False, left_us=10**9, right_us=10**9)
        )
        assert not liveness.judge(told_wrongly, pairs[-1].exposed_monotonic_s).counts


def test_a_recording_of_a_frozen_camera_is_a_frozen_camera(tmp_path):
    write_recording(tmp_path, count=10)
    for number in range(1, 10):
        (tmp_path / "left" / f"{number:06d}.png").write_bytes((tmp_path / "left" / "000000.png").read_bytes())
    with RecordingSource(tmp_path, rate_hz=0, loop=False) as source:
        liveness = Liveness(SETTINGS, 0.0, numbered=True)
        pairs = [source.next(1) for _ in range(10)]
        counts = [liveness.judge(Exposure.from_source(pair), pair.exposed_monotonic_s).counts for pair in pairs]
    assert counts == [True] + [False] * 9


def write_recording(folder, count: int) -> None:
    for side in ("left", "right"):
        (folder / side).mkdir()
    for number in range(count):
        for side, picture in zip(("left", "right"), pictures(number), strict=True):
            cv2.imwrite(str(folder / side / f"{number:06d}.png"), picture)


def test_no_picture_of_the_mill_is_objected_to():
    with MillSource(seed=5, rate_hz=0, prepared_frames=30) as source:
        liveness = Liveness(SETTINGS, 0.0, numbered=False)
        pairs = [source.next(5) for _ in range(75)]
    verdicts = [liveness.judge(Exposure.from_source(pair), pair.exposed_monotonic_s) for pair in pairs]
    assert [verdict.counts for verdict in verdicts] == [False] + [True] * 74


@pytest.mark.parametrize("name", ["line_a"])
def test_no_picture_of_a_recording_is_objected_to(recordings, name):
    scenes = [folder for folder in sorted((recordings / name / "scenes").iterdir()) if (folder / "left").is_dir()]
    assert scenes
    for scene in scenes:
        with RecordingSource(scene, rate_hz=0, loop=False) as source:
            liveness = Liveness(SETTINGS, 0.0, numbered=False)
            first, second = (source.next(1) for _ in range(2))
            assert not liveness.judge(Exposure.from_source(first), first.exposed_monotonic_s).counts
            assert liveness.judge(Exposure.from_source(second), second.exposed_monotonic_s).counts, scene


def test_a_clock_that_is_set_by_a_day_changes_no_verdict(monkeypatch):
    monkeypatch.setattr("time.time", lambda: 1e9)
    liveness = Liveness(SETTINGS, 100.0, numbered=True)
    assert liveness.judge(exposure(1), 100.1).counts
    monkeypatch.setattr("time.time", lambda: 1e9 + 86_400)
    assert liveness.judge(exposure(2), 100.2) == (True, {}, 0.0)
