"""The loop of the stereo sizing station: readings, camera and rig trouble, warm-up, its end."""

import dataclasses
import hashlib
import select
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from mill_scenes import perfect_rig
from station_thread import Station

from appliance.cameras.exposure_control import ExposureGuard
from appliance.cameras.settings import ExposureSettings
from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.processes import station_process as process
from appliance.processes.message import StateMessage
from appliance.simulation.bars.bars import bar_at
from appliance.simulation.bars.study_scenes import draw
from appliance.sizing import station as sizing
from appliance.sizing.message import ReadingMessage
from appliance.sizing.stereo.gauge import TimedGauge
from appliance.sizing.stereo.rig_file import RigError, load_rig, save_rig
from appliance.sizing.stereo.settings import SizingSettings
from vision.sizing.gauge import Gauge
from vision.sizing.tangent.gauge import TangentGauge

SIDES = ("left", "right")


@pytest.fixture(scope="module")
def rig(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("rig") / "rig.json"
    save_rig(mill_rig(MillSource(seed=1, rate_hz=0)), path)
    return path


@pytest.fixture
def recording(tmp_path) -> Path:
    with MillSource(seed=1, rate_hz=0) as source:
        for number in range(2):
            pair = source.next(1)
            for side, picture in zip(SIDES, (pair.left, pair.right), strict=True):
                (tmp_path / side).mkdir(exist_ok=True)
                cv2.imwrite(str(tmp_path / side / f"{number:06d}.png"), picture)
    return tmp_path


@pytest.fixture
def start(monkeypatch) -> Iterator:
    monkeypatch.setattr(sizing, "RETRY_PAUSE_S", 0.05)
    stations: list[Station] = []

    def begin(**settings) -> Station:
        stations.append(Station(settings))
        return stations[-1]

    yield begin
    for station in stations:
        station.end()


def camera(folder: Path, **more) -> dict:
    return {"kind": "recording", "path": folder, "rate_hz": 20.0, **more}


def test_readings_carry_the_diameter_and_the_moment_of_their_exposure(start, recording, rig):
    station = start(rig=rig, camera=camera(recording))
    first, second = station.hear(), station.hear()
    assert first.reading.diameter_mm == pytest.approx(bar_at(1, 0).diameter_mm, abs=0.3)
    assert first.reading.valid
    assert first.simulated
    lost = second.sequence - first.sequence
    assert second.exposed_monotonic_s - first.exposed_monotonic_s == pytest.approx(lost / 20)
    assert second.exposed_utc_ms - first.exposed_utc_ms == pytest.approx(1000 * lost / 20, abs=5)


def test_where_a_recording_begins_again_another_bar_does(start, recording, rig):
    station = start(rig=rig, camera=camera(recording))
    heard = [station.hear() for _ in range(6)]
    assert heard[-1].stretch > 0
    assert {message.reading.bar_frames for message in heard} <= {1, 2}


def test_while_it_compiles_it_says_so_before_anything_else(start, recording, rig):
    station = start(rig=rig, camera=camera(recording))
    assert station.hear_any() == StateMessage(state="warming")
    assert isinstance(station.hear(), ReadingMessage)


def test_a_recording_played_once_ends_in_a_state_and_no_further_reading(start, recording, rig):
    station = start(rig=rig, camera=camera(recording, rate_hz=0, loop=False))
    heard = [station.hear() for _ in range(5)]
    assert [type(message) for message in heard] == [ReadingMessage] * 2 + [StateMessage] * 3
    assert {message.fault for message in heard[2:]} == {"recording_over"}


def test_a_picture_that_breaks_is_a_lost_camera_until_it_is_mended(start, recording, rig):
    picture = recording / "right" / "000001.png"
    whole = picture.read_bytes()
    picture.write_bytes(whole[:3000])
    station = start(rig=rig, camera=camera(recording, rate_hz=0))
    fault = station.hear_until(StateMessage)
    assert fault.fault == "camera_lost"
    assert str(picture) in fault.detail
    picture.write_bytes(whole)
    assert station.hear_until(ReadingMessage).reading.valid


def test_a_recording_of_a_frozen_camera_is_played_to_its_end(start, recording, rig, monkeypatch):
    monkeypatch.setattr(process, "REOPEN_AFTER_S", 0.2)
    for number in range(1, 20):
        for side in SIDES:
            picture = recording / side / f"{number:06d}.png"
            picture.write_bytes((recording / side / "000000.png").read_bytes())
    station = start(rig=rig, camera=camera(recording, loop=False), liveness={"lost_after_ms": 100})
    assert station.hear_until(ReadingMessage).reading.valid
    seen = [station.hear_until(StateMessage).fault]
    while seen[-1] != "recording_over":
        assert len(seen) < 50
        seen.append(station.hear_until(StateMessage).fault)
    assert seen[0] == "camera_frozen"


def test_a_rig_that_is_missing_is_a_fault_until_it_is_there(start, recording, rig, tmp_path):
    late = tmp_path / "late.json"
    station = start(rig=late, camera=camera(recording))
    fault = station.hear()
    assert fault.fault == "rig_unusable"
    assert str(late) in fault.detail
    save_rig(load_rig(rig), late)
    assert station.hear_until(ReadingMessage).reading.valid


def test_a_known_error_that_another_calibration_had_gives_a_fault_and_no_value(start, recording, rig):
    digest = hashlib.sha256(rig.read_bytes()).hexdigest()
    known = {"added_mm": 0.1, "expanded_mm": 0.03, "date": "2026-11-28", "reason": "master 250.00", "who": "A. Smith"}
    other = start(rig=rig, camera=camera(recording), adjustment=known | {"calibration_sha256": "5e" * 32})
    fault = other.hear()
    assert (fault.fault, "sizing.adjustment.added_mm" in fault.detail) == ("rig_unusable", True)
    own = start(rig=rig, camera=camera(recording), adjustment=known | {"calibration_sha256": digest})
    reading = own.hear_until(ReadingMessage)
    assert (reading.adjustment_mm, reading.scale_sha256) == (0.1, digest)


def test_a_camera_that_gives_nothing_is_lost(start, recording, rig, monkeypatch):
    monkeypatch.setattr(sizing, "PAIR_TIMEOUT_S", 0.1)
    station = start(rig=rig, camera=camera(recording, rate_hz=0.5))
    assert station.hear_until(StateMessage).fault == "camera_lost"


def test_the_mill_without_a_rig_calibrates_itself_and_says_that_it_is_starting(start):
    station = start(camera={"kind": "mill", "seed": 4, "rate_hz": 20.0})
    assert station.hear() == StateMessage(state="starting")
    assert station.hear_until(ReadingMessage).simulated


def test_a_rig_without_world_frame_is_refused_by_name(rig):
    without_world = dataclasses.replace(load_rig(rig), has_world=False)
    with pytest.raises(RigError, match=r"^line\.json: .*world"):
        TimedGauge(without_world, "line.json", Gauge)


def test_the_process_ends_when_the_supervisor_dies_with_messages_unread(recording, rig):
    ours, theirs = socket.socketpair()
    words = [sys.executable, "-P", "-m", "appliance.sizing.station", str(theirs.fileno())]
    process = subprocess.Popen(words, pass_fds=(theirs.fileno(),), stdin=subprocess.DEVNULL)
    theirs.close()
    camera = {"kind": "recording", "path": str(recording), "rate_hz": 20}
    settings = SizingSettings.model_validate({"camera": camera, "rig": str(rig)})
    ours.sendall(settings.model_dump_json().encode() + b"\n")
    select.select([ours], [], [], 60)
    ours.close()
    try:
        process.wait(10)
    finally:
        process.kill()


def grey(scene, factor):
    """Both pictures of the channel that glows most, exposed for longer: a colour camera has other channels left."""
    return [
        np.clip(picture[:, :, 2].astype(float) * factor, 0, 255).astype(np.uint8)
        for picture in (scene.left, scene.right)
    ]


def test_edges_that_stay_overexposed_are_a_fault_with_an_exposure_to_try_or_are_set_right():
    scene = draw("clean", 20_003)
    gauge = TangentGauge(perfect_rig(scene.rig, scene.response))
    good, over = gauge.measure(*grey(scene, 1)), gauge.measure(*grey(scene, 3))
    assert good.valid
    assert good.clipped_share < 0.05 < over.clipped_share
    assert good.limb_light > 0.1

    class Camera:
        exposure_us = 500.0

        def set_exposure(self, exposure_us):
            self.exposure_us = exposure_us

    pair = SimpleNamespace(exposure_us=500.0)
    settings = ExposureSettings(after_s=0)
    told = sizing._exposure_faults(ExposureGuard(settings, adjustable=False), over, pair, Camera())
    assert "about 400 µs instead of 500" in told["exposure_high"]
    camera = Camera()
    control = ExposureGuard(settings.model_copy(update={"control": True}), adjustable=True)
    assert not sizing._exposure_faults(control, over, pair, camera)
    assert camera.exposure_us == 400


def test_a_rig_that_is_replaced_while_a_camera_is_away_waits_for_a_reload(start, recording, rig, tmp_path):
    used = tmp_path / "used.json"
    save_rig(load_rig(rig), used)
    picture = recording / "right" / "000001.png"
    whole = picture.read_bytes()
    station = start(rig=used, camera=camera(recording, rate_hz=0))
    before = station.hear_until(ReadingMessage).reading.diameter_mm
    used.write_text("a recalibration that nobody has judged yet")
    picture.write_bytes(whole[:3000])
    assert station.hear_until(StateMessage).fault == "camera_lost"
    picture.write_bytes(whole)
    assert station.hear_until(ReadingMessage).reading.diameter_mm == pytest.approx(before, abs=10.0)
