import logging

import pytest

from appliance.faults import FAULTS, DeviceState, Faults
from appliance.supervisor import STATION_FAULTS


def test_codes_and_names_are_unique_and_every_row_says_what_to_do():
    assert len({row.code for row in FAULTS}) == len({row.name for row in FAULTS}) == len(FAULTS)
    for row in FAULTS:
        assert row.text
        assert row.remedy
        assert row.severity in {logging.WARNING, logging.ERROR}


def test_whoever_points_at_a_fault_points_at_one_that_exists():
    assert set(STATION_FAULTS) <= {row.name for row in FAULTS}


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
