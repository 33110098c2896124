"""The laser over Modbus: what its register says, and what happens when it says nothing."""

import math
import time

import numpy as np
import pytest
from mill_scenes import perfect_rig
from modbus_wire import eventually
from pydantic import ValidationError
from range_register import RangeRegister

from appliance.cameras.recording.time_stamps import STAMPS_FILE, Stamps, read_stamps, stamps_table
from appliance.cameras.source import FramePair
from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.laser import Laser
from appliance.simulation.true_rig import default_rig
from appliance.sizing.range_sensor import modbus
from appliance.sizing.range_sensor.sensor import NoRangeSensor, RangeReading, steady_range_mm
from appliance.sizing.range_sensor.settings import MILL_DIRECTION, MILL_ORIGIN_MM, ModbusRange
from appliance.sizing.stereo.gauge import RangeRay
from appliance.sizing.stereo.settings import SizingSettings

BEAM = {"origin_mm": [0, 0, 2200], "direction": [0, 0, -2], "u_mm": 0.5}
PICTURE = np.zeros((4, 4), np.uint8)


def sensor_of(register, **more):
    given = {"kind": "modbus", "host": "127.0.0.1", "port": register.port, "address": 7}
    return modbus.ModbusRangeSensor(ModbusRange(**given | BEAM | more))


def now():
    return FramePair(PICTURE, PICTURE, 0, 0, 0, exposed_monotonic_s=time.monotonic(), exposed_utc_ms=0)


def has_range(sensor):
    return lambda: math.isfinite(sensor.beside(now()).range_mm)


def test_the_range_is_count_times_scale_plus_offset():
    with RangeRegister(7, [20_517]) as register, sensor_of(register, offset_mm=-3.5, unit_id=9) as sensor:
        assert eventually(has_range(sensor))
        assert sensor.beside(now()).range_mm == pytest.approx(2048.2)
        assert sensor.faults == {}
        assert register.asked[0][6:] == bytes([9, 4, 0, 7, 0, 1])


def test_two_words_are_most_significant_first():
    with RangeRegister(7, [3, 0x0D40]) as register, sensor_of(register, words=2, scale_mm=0.01) as sensor:
        assert eventually(has_range(sensor))
        assert sensor.beside(now()).range_mm == pytest.approx(2000.0)


def test_a_range_beyond_its_limits_is_none_and_no_fault():
    with RangeRegister(7, [65_535]) as register, sensor_of(register) as sensor:
        assert eventually(lambda: len(register.asked) > 3)
        assert not has_range(sensor)()
        assert sensor.faults == {}


@pytest.fixture
def hasty(monkeypatch):
    for name in ("ANSWER_WITHIN_S", "LOST_AFTER_S", "RETRY_PAUSE_S"):
        monkeypatch.setattr(modbus, name, 0.1)


def test_a_sensor_that_falls_silent_is_a_fault_and_gives_no_range_until_it_answers_again(hasty):
    with RangeRegister(7, [20_000]) as register, sensor_of(register) as sensor:
        assert eventually(has_range(sensor))
        register.answers = False
        assert eventually(lambda: "range_lost" in sensor.faults)
        assert f"127.0.0.1:{register.port}" in sensor.faults["range_lost"]
        assert not has_range(sensor)()
        register.answers = True
        assert eventually(lambda: has_range(sensor)() and not sensor.faults)


def test_a_register_that_is_refused_is_a_fault_with_its_address(hasty):
    with RangeRegister(8, [20_000]) as register, sensor_of(register) as sensor:
        assert eventually(lambda: "refuses register 7 of unit 1" in sensor.faults.get("range_lost", ""))


def test_nobody_there_is_a_fault(hasty):
    register = RangeRegister(7, [20_000])
    with register:
        pass
    with sensor_of(register) as sensor:
        assert eventually(lambda: "nobody answers" in sensor.faults.get("range_lost", ""))


@pytest.mark.parametrize(("moment_s", "range_mm"), [(10.03, 1.0), (10.09, 2.0), (10.21, math.nan), (9.9, math.nan)])
def test_the_range_nearest_to_the_exposure_counts_unless_all_but_one_are_too_old(moment_s, range_mm):
    readings = [RangeReading(10.0, 1.0), RangeReading(10.1, 2.0)]
    assert steady_range_mm(readings, moment_s, 0.1, u_mm=0.5) == pytest.approx(range_mm, nan_ok=True)


@pytest.mark.parametrize(("later_mm", "counts"), [(1.4, True), (-1.4, True), (1.6, False), (math.nan, False)])
def test_no_range_counts_while_the_bar_hops(later_mm, counts):
    readings = [RangeReading(10.0, 2000.0), RangeReading(10.02, 2000.0 + later_mm)]
    assert math.isfinite(steady_range_mm(readings, 10.0, 0.05, u_mm=0.5)) == counts


def test_a_pair_without_a_laser_stays_as_it_is():
    pair = now()
    with NoRangeSensor() as sensor:
        assert sensor.beside(pair) is pair


def test_the_beam_has_any_length_and_ends_at_the_range():
    ray = RangeRay((0.0, 0.0, 2200.0), (0.0, 0.0, -2.0), 0.5)
    rig = perfect_rig(default_rig())
    assert ray.point(2000.0, rig).point_mm == pytest.approx([0, 0, 200])
    along = ray.point(2000.0, rig.along_line(30.0))  # the beam was found in the boards' frame
    assert along.point_mm == pytest.approx([0, 100, 200 * math.cos(math.pi / 6)])
    assert ray.point(math.nan, rig) is None


@pytest.mark.parametrize(("key", "value"), [("direction", [0, 0, 0]), ("origin_mm", [0, 0]), ("u_mm", 0)])
def test_a_beam_that_cannot_be_is_refused(key, value):
    with pytest.raises(ValidationError, match=key):
        ModbusRange(**{"kind": "modbus", "host": "laser", "address": 0} | BEAM | {key: value})


def test_the_mills_laser_belongs_to_the_mill():
    assert SizingSettings.model_validate({"range": {"kind": "mill"}}).range.u_mm > 0
    camera = {"kind": "stream", "left": "rtsp://a", "right": "rtsp://b"}
    with pytest.raises(ValidationError, match="only the simulated mill"):
        SizingSettings.model_validate({"camera": camera, "range": {"kind": "mill"}})


def test_ranges_of_a_recording_come_back_to_the_last_digit(tmp_path):
    stamps = {3: Stamps(10, 11, True, 2050.1234567891), 4: Stamps(20, 21, False)}
    (tmp_path / STAMPS_FILE).write_bytes(stamps_table(stamps))
    again = read_stamps(tmp_path)
    assert again[3] == stamps[3]
    assert again[4][:3] == stamps[4][:3]
    assert math.isnan(again[4].range_mm)


def test_the_mills_laser_meets_the_top_of_the_bar_or_the_rollers():
    laser = Laser(np.array(MILL_ORIGIN_MM), np.array(MILL_DIRECTION))
    bar = Bar(diameter_mm=200.0, offset_mm=60.0, lift_mm=3.0)
    assert laser.true_range_mm(bar) == pytest.approx(2200 - 103 - math.sqrt(100**2 - 60**2))
    assert laser.true_range_mm(Bar(diameter_mm=100.0, offset_mm=60.0)) == 2200
    assert laser.true_range_mm(Bar(diameter_mm=200.0, head_mm=-10.0)) == 2200
    assert laser.true_range_mm(None) == 2200


def test_the_mills_laser_sees_an_oval_bar_as_it_is():
    laser = Laser(np.array([0.0, 0.0, 2200.0]), np.array([0.0, 0.0, -1.0]))
    upright, lying = (laser.true_range_mm(Bar(200.0, ovality_mm=8.0, ovality_deg=deg)) for deg in (90.0, 0.0))
    assert upright == pytest.approx(2200 - 204)  # its greatest diameter is 204
    assert lying == pytest.approx(2200 - 196)


@pytest.mark.parametrize("measures_mm", [[6000, 100], [100, 100], [-1, 100], [100]])
def test_a_measuring_range_has_its_smaller_end_first(measures_mm):
    with pytest.raises(ValueError, match="measures_mm"):
        ModbusRange(kind="modbus", host="laser", address=7, measures_mm=measures_mm, **BEAM)
