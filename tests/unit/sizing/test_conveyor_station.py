"""The sizing station with one camera between barriers: true values, or none and a sentence."""

import math
import time
from dataclasses import replace

import cv2
import numpy as np
import pytest
from station_thread import Station

from appliance.cameras.source import Frame
from appliance.cli import main as cli
from appliance.processes.message import StateMessage
from appliance.service.doctor import examine
from appliance.simulation.bars.bars import Bar, bar_at
from appliance.simulation.thermal_line import ThermalLine, thermal_camera
from appliance.simulation.write_recording import write_thermal_recording
from appliance.sizing import station as sizing
from appliance.sizing.conveyor.settings import ConveyorLine, ConveyorSettings
from appliance.sizing.message import ReadingMessage
from appliance.sizing.published import PUBLISHED
from vision.reasons import Reason

BAR = Bar(165.0, 20.0, 0.0)
LINE = ThermalLine(thermal_camera(), bar=BAR, seed=3)
LENGTHS = {"barrier_mm": 500.0, "barrier_height_mm": 100.0}
LATE = {"lost_after_ms": 100}


def test_columns_of_barriers_are_two_from_left_to_right_or_none():
    for columns in ([], [120.0, 480.0]):
        assert ConveyorLine(barrier_mm=500.0, near_columns=columns).near_columns == columns
    for columns in ([480.0, 120.0], [120.0], [120.0, 300.0, 480.0]):
        with pytest.raises(ValueError, match="two columns are wanted"):
            ConveyorLine(barrier_mm=500.0, near_columns=columns)


@pytest.fixture
def start(monkeypatch):
    monkeypatch.setattr(sizing, "RETRY_PAUSE_S", 0.05)
    stations: list[Station] = []

    def begin(camera, conveyor=LENGTHS, **settings) -> Station:
        stations.append(Station({"method": "conveyor", "camera": camera, "conveyor": conveyor, **settings}))
        return stations[-1]

    yield begin
    for station in stations:
        station.end()


@pytest.fixture
def recording(tmp_path):
    write_thermal_recording(tmp_path / "recording", LINE, empty=3, frames=3)
    return tmp_path / "recording"


def played(folder, **more):
    return {"kind": "recording", "path": folder, "rate_hz": 0.0, **more}


def picture(line=LINE):
    return line.pictures(0, 1)[0]


def empty(line=LINE):
    return line.pictures(1, 0)[0]


def saved(path, image):
    cv2.imwrite(str(path), image)
    return path


def test_the_simulated_line_is_measured_as_it_is(start):
    told = {"barrier_mm": 600.0, "barrier_height_mm": 100.0, "response_exponent": 1.0}
    station = start({"kind": "mill", "seed": 11, "rate_hz": 60.0}, told)
    valid, without = 0, 0
    while valid < 40 or not without:
        message = station.hear_until(ReadingMessage)
        bar = bar_at(11, message.sequence)
        assert message.simulated
        assert message.reading.windows_total == 24
        assert math.isnan(message.reading.diameter_virtual_board_mm)
        if message.reading.valid and bar is not None:
            valid += 1
            assert message.reading.diameter_mm == pytest.approx(
                bar.diameter_mm, abs=message.reading.expanded_uncertainty_mm
            )
            assert 0.1 < message.reading.expanded_uncertainty_mm < 0.6
        elif not message.reading.valid:
            without += 1
            assert math.isnan(message.reading.diameter_mm)
            assert message.reading.reasons


def test_a_recording_finds_its_empty_line_itself(start, recording):
    station = start(played(recording, loop=False))
    heard = [station.hear_until(ReadingMessage) for _ in range(6)]
    assert [message.reading.valid for message in heard] == [False] * 3 + [True] * 3
    assert {message.reading.reasons for message in heard[:3]} == {int(Reason.NO_BAR)}
    for message in heard[3:]:
        assert message.reading.diameter_mm == pytest.approx(
            BAR.diameter_mm, abs=message.reading.expanded_uncertainty_mm
        )
        assert math.isnan(PUBLISHED["hop_height"](message.reading)), "one camera assumes that the bar lies"
    assert station.hear_until(StateMessage).fault == "recording_over"


def test_a_frozen_camera_gives_no_further_value(start, recording):
    for number in range(6, 30):
        (recording / f"{number:06d}.png").write_bytes((recording / "000005.png").read_bytes())
    station = start(played(recording, rate_hz=20.0, loop=False), liveness=LATE)
    seen = []
    while not (seen and isinstance(seen[-1], StateMessage) and seen[-1].fault == "recording_over"):
        seen.append(station.hear())
    frozen = [message for message in seen if isinstance(message, ReadingMessage) and message.sequence >= 5]
    assert len(frozen) <= 1, "the first of them may be new to a station that was late"
    assert "camera_frozen" in {message.fault for message in seen if isinstance(message, StateMessage)}


class Camera:
    """A camera that shows the bar a few times and then the same picture for ever."""

    simulated = False

    def __init__(self, moving: int) -> None:
        self._pictures = LINE.pictures(0, moving)
        self._number = -1

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def next(self, _timeout_s):
        time.sleep(0.02)
        self._number += 1
        shown = self._pictures[min(self._number, len(self._pictures) - 1)]
        return Frame(shown, sequence=self._number, exposed_monotonic_s=time.monotonic(), exposed_utc_ms=0)


def test_a_live_camera_that_freezes_is_a_fault_and_its_last_value_is_not_said_again(start, tmp_path, monkeypatch):
    monkeypatch.setattr(ConveyorSettings, "make_source", lambda _: Camera(moving=5))
    background = saved(tmp_path / "empty.png", empty())
    station = start({"kind": "stream", "address": "0"}, LENGTHS | {"background": background}, liveness=LATE)
    heard = [station.hear()]
    while not isinstance(heard[-1], StateMessage) and len(heard) < 20:
        heard.append(station.hear())
    assert [message.sequence for message in heard[:-1]] == [1, 2, 3, 4], "the first is only compared with"
    for message in heard[:-1]:
        assert message.reading.diameter_mm == pytest.approx(
            BAR.diameter_mm, abs=message.reading.expanded_uncertainty_mm
        )
        assert not message.simulated
    assert heard[-1].fault == "camera_frozen"
    assert isinstance(station.hear(), StateMessage)


def test_a_background_that_is_missing_is_a_fault_until_it_is_there(start, recording, tmp_path):
    late = tmp_path / "empty.png"
    station = start(played(recording), LENGTHS | {"background": late})
    fault = station.hear()
    assert fault.fault == "empty_line_unusable"
    assert f"{late}: no such picture" in fault.detail
    saved(late, empty())
    assert station.hear_until(ReadingMessage).reading.windows_total == 24


WRONG = {
    "another size": (lambda: empty()[:240], ("640 x 240", "640 x 480")),
    "half hidden": (lambda: empty(replace(LINE, hidden="left", hidden_from_mm=0.0)), ("fifth of one is hidden",)),
    "bent": (lambda: empty(replace(LINE, warp_mm=8.0)), ("not straight",)),
    "too small": (lambda: np.full((20, 30), 40, np.uint8), ("30 x 20 pixels are too small", "32 x 32")),
    "coloured by a palette": (lambda: cv2.applyColorMap(empty(), cv2.COLORMAP_JET), ("in false colours",)),
    "without a line": (lambda: np.full((480, 640), 40, np.uint8), ("no pair of barriers",)),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_background_that_cannot_be_the_empty_line_is_a_fault_that_says_so(start, recording, tmp_path, name):
    make, parts = WRONG[name]
    path = saved(tmp_path / "empty.png", make())
    station = start(played(recording), LENGTHS | {"background": path})
    fault = station.hear()
    assert fault.fault == "empty_line_unusable"
    for part in (str(path), *parts):
        assert part in fault.detail


def test_lengths_that_contradict_each_other_are_a_fault_that_names_them(start, recording):
    station = start(played(recording), {"barrier_mm": 100.0, "barrier_height_mm": 500.0})
    assert "sizing.conveyor: barrier_height_mm" in station.hear().detail


def test_a_camera_without_a_picture_of_the_empty_line_is_told_which_setting_is_missing(start):
    station = start({"kind": "stream", "address": "/dev/null"})
    assert "sizing.conveyor.background" in station.hear().detail


def test_a_camera_that_was_moved_since_its_background_was_taken_gives_no_value(start, recording, tmp_path):
    higher = replace(LINE, camera=replace(thermal_camera(2640.0, 812.0), K=LINE.camera.K))
    path = saved(tmp_path / "empty.png", empty(higher))
    station = start(played(recording), LENGTHS | {"background": path})
    heard = [station.hear_until(ReadingMessage) for _ in range(6)]
    assert not any(message.reading.valid for message in heard)
    assert {message.reading.reasons for message in heard[-3:]} & {int(Reason.CAMERA_MOVED)}


def test_an_overexposed_bar_gives_no_value_and_a_fault_with_an_exposure(start, recording, tmp_path):
    for number in range(3, 6):
        path = recording / f"{number:06d}.png"
        saved(path, np.clip(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) * 1.4, 0, 255).astype(np.uint8))
    background = saved(tmp_path / "empty.png", empty())
    station = start(played(recording), LENGTHS | {"background": background}, exposure={"after_s": 0.0})
    heard = [station.hear_until(ReadingMessage) for _ in range(6)]
    assert not any(message.reading.valid for message in heard)
    assert any("overexposed" in message.faults.get("exposure_high", "") for message in heard)


def test_the_ovality_of_the_product_is_part_of_the_uncertainty(start, recording):
    found = []
    for ovality_mm in (0.0, 3.0):
        station = start(played(recording), ovality_mm=ovality_mm)
        found.append(next(m for _ in range(9) if (m := station.hear_until(ReadingMessage)).reading.valid))
    assert found[1].reading.expanded_uncertainty_mm ** 2 - found[
        0
    ].reading.expanded_uncertainty_mm ** 2 == pytest.approx(3.0, rel=0.05)


CONFIG = """
[sizing]
method = "conveyor"
[sizing.conveyor]
barrier_mm = 500
barrier_height_mm = 100
{background}
[sizing.camera]
kind = "recording"
path = "recording"
"""


def checks(tmp_path, background=""):
    config = tmp_path / "hotgauge.toml"
    config.write_text(CONFIG.format(background=background))
    return {check.name: check for check in examine(config)}


@pytest.mark.usefixtures("recording")
def test_the_doctor_looks_at_the_barriers_and_at_the_pictures(tmp_path):
    told = checks(tmp_path)
    assert told["barriers"].verdict == "good"
    assert "640 x 480" in told["cameras"].text
    assert "rig" not in told


@pytest.mark.usefixtures("recording")
def test_the_doctor_says_what_is_wrong_with_the_empty_line(tmp_path):
    saved(tmp_path / "small.png", empty()[:240])
    assert "no such picture" in checks(tmp_path, 'background = "absent.png"')["barriers"].text
    told = checks(tmp_path, 'background = "small.png"')["cameras"]
    assert told.verdict == "BAD"
    assert "640 x 240" in told.text


@pytest.mark.usefixtures("recording")
@pytest.mark.parametrize(
    ("conveyor", "more", "said"),
    [(True, ["--rig", "rig.json"], "--rig: sizing.method"), (False, [], "--rig: the rig file")],
)
def test_replay_asks_for_a_rig_only_where_one_is_needed(tmp_path, capsys, conveyor, more, said):
    config = tmp_path / "hotgauge.toml"
    config.write_text(CONFIG.format(background="") if conveyor else "")
    assert cli.main(["replay", str(tmp_path / "recording"), "--config", str(config), *more]) == 2
    assert said in capsys.readouterr().err
