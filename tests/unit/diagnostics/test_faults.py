"""Faults that are active: reported, cleared, and the device state that follows."""

import logging

import pytest

from appliance.diagnostics.fault_table import FAULTS
from appliance.diagnostics.faults import Faults
from plc.codes import DeviceState


def test_codes_and_names_are_unique_and_every_row_says_what_to_do():
    assert len({row.code for row in FAULTS}) == len({row.name for row in FAULTS}) == len(FAULTS)
    for row in FAULTS:
        assert row.text
        assert row.remedy
        assert row.severity in {logging.WARNING, logging.ERROR}


def test_each_fault_has_a_bit_of_its_own_in_the_word():
    assert sorted(row.bit for row in FAULTS) == sorted({row.bit for row in FAULTS})
    assert all(0 <= row.bit < 32 for row in FAULTS)
    faults = Faults()
    for row in FAULTS:
        faults.report(row.name, active=True)
        assert faults.word == 1 << row.bit
        faults.report(row.name, active=False)
        faults.acknowledge()
        assert faults.word == 0


def test_the_state_is_that_of_the_worst_active_fault():
    faults = Faults()
    assert faults.state == DeviceState.GOOD
    faults.report("recording_over", active=True)
    assert faults.state == DeviceState.FUNCTION_CHECK
    faults.report("camera_lost", active=True)
    assert faults.state == DeviceState.FAILURE
    faults.report("camera_lost", active=False)
    assert faults.state == DeviceState.FUNCTION_CHECK
    assert faults.active == {"recording_over"}


def test_only_changes_are_logged(caplog):
    caplog.set_level(logging.INFO, logger="hotgauge")
    faults = Faults()
    for active in (False, True, True, True, False, False):
        faults.report("camera_lost", active=active, detail="left/000001.jpg: breaks off")
    assert [record.levelno for record in caplog.records] == [logging.ERROR, logging.INFO]
    assert "left/000001.jpg: breaks off" in caplog.text


def test_a_fault_that_is_not_in_the_table_is_a_wrong_call():
    with pytest.raises(ValueError, match=r"name: .*'toothache'"):
        Faults().report("toothache", active=True)


def test_what_a_station_does_not_tell_any_more_is_over_and_the_other_station_keeps_its_own():
    faults = Faults()
    faults.report_station("sizing", {"camera_frozen": "left", "pairs_slow": "one every 700 ms"})
    faults.report_station("ingot", {"camera_frozen": "its only one"})
    faults.report("reading_stale", active=True, station="sizing")
    faults.report_station("sizing", {})
    assert faults.active == {"camera_frozen", "reading_stale"}
    assert faults.active_at("sizing") == {"reading_stale"}
    faults.report_station("ingot", {})
    assert faults.active == {"reading_stale"}


@pytest.mark.parametrize("name", ["toothache", "station_failing", ""])
def test_a_station_tells_only_of_what_it_can_know(name):
    with pytest.raises(ValueError, match="found: "):
        Faults().report_station("sizing", {name: ""})


def test_a_latching_fault_stays_in_the_word_until_it_is_over_and_acknowledged():
    faults = Faults()
    faults.report("station_failing", active=True)
    bit = faults.word
    faults.acknowledge()
    assert (faults.word, faults.state) == (bit, DeviceState.FAILURE)
    faults.report("station_failing", active=False)
    assert (faults.word, faults.state) == (0, DeviceState.GOOD)  # seen while it was there
    faults.report("station_failing", active=True)
    faults.report("station_failing", active=False)
    assert (faults.word, faults.state) == (bit, DeviceState.MAINTENANCE_REQUIRED)
    assert faults.active == frozenset()
    faults.acknowledge()
    assert (faults.word, faults.state) == (0, DeviceState.GOOD)


def test_the_log_has_fields_for_machines(caplog):
    faults = Faults(lambda: 70000)
    faults.report("camera_frozen", active=True, detail="left", station="sizing")
    (record,) = caplog.records
    fields = {name: value for name, value in vars(record).items() if name.startswith("HOTGAUGE_")}
    assert fields == {
        "HOTGAUGE_FAULT": 103,
        "HOTGAUGE_FAULT_NAME": "camera_frozen",
        "HOTGAUGE_STATION": "sizing",
        "HOTGAUGE_PRODUCT": 70000,
    }
