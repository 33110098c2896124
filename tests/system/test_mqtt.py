"""Rows by MQTT through Mosquitto: the same as in the history, none lost while the broker is away."""

import contextlib
import sqlite3
import time
from pathlib import Path

import pytest
from modbus_wire import write_registers
from mosquitto import Broker
from plc_view import has_value, look, wait_for
from rehearsal import rehearsing
from running import free_port

from appliance.delivery import mqtt
from appliance.delivery.message import RowLine
from appliance.delivery.mqtt import MqttSender
from appliance.delivery.settings import MqttSettings
from appliance.diagnostics.fault_table import FAULTS
from appliance.history import database
from appliance.history.settings import HistorySettings
from appliance.supervisor.supervisor import Supervisor
from plc.registers import SET_POINTS

pytestmark = pytest.mark.waiting

BITS = {row.name: 1 << row.bit for row in FAULTS}


@pytest.fixture
def broker(tmp_path_factory):
    broker = Broker(tmp_path_factory.mktemp("broker"), free_port())
    broker.start()
    broker.subscribe()
    yield broker
    broker.close()


def settings(broker: Broker, **more) -> MqttSettings:
    files = {
        "authority": broker.folder / "authority.pem",
        "certificate": broker.folder / "client-gauge.pem",
        "key": broker.folder / "client-gauge.key",
    }
    return MqttSettings(host="127.0.0.1", port=broker.port, **files | more)


def in_history(folder: Path) -> dict[int, float | None]:
    with contextlib.closing(sqlite3.connect(folder / database.FILE_NAME)) as connection:
        return dict(connection.execute("SELECT sequence, diameter_mm FROM readings").fetchall())


def test_everything_that_the_history_has_reaches_the_broker_though_it_was_away(broker, tmp_path, monkeypatch):
    history = tmp_path / "history"
    with rehearsing("fake_station", tmp_path, monkeypatch) as rehearsal:
        rehearsal.keep_in(None, history)
        sections = {"mqtt": settings(broker), "history": HistorySettings(directory=history, reading_period_s=0.0)}
        rehearsal.settings = rehearsal.settings.model_copy(update=sections)
        rehearsal.supervisor = Supervisor(rehearsal.settings)
        rehearsal.start()
        with rehearsal.connect() as wire:
            wait_for(wire, has_value, 5)
            assert broker.wait_for(lambda: ("hotgauge/state", "online") in broker.received, 15)
            wire.ask(write_registers(SET_POINTS.start, 30000, 200, 200))
            assert broker.wait_for(lambda: bool(broker.rows("alarms")), 10)
            broker.stop()
            time.sleep(5)
            sequence = look(wire)["sequence"]
            assert has_value(look(wire))
            broker.start()
            assert broker.wait_for(lambda: len(broker.rows("readings")) >= sequence, 40)
            assert look(wire)["fault_word"] == 0
        rehearsal.finish()
    kept = in_history(history)
    sent = {row["sequence"]: row["diameter_mm"] for row in broker.rows("readings")}
    lost = kept.keys() - sent.keys()
    assert not [one for one in lost if one < max(kept) - 60]  # what came within the last seconds of the run may wait
    assert len(kept) > 150
    assert all(sent[one] == kept[one] for one in kept.keys() & sent.keys())
    (alarm, *_) = broker.rows("alarms")
    assert alarm["name"] == "alarm_out_of_tolerance"
    assert alarm["came_utc"].endswith("Z")
    assert {row["address"] for row in broker.rows("set_point_writes")} == {"127.0.0.1"}
    assert broker.wait_for(lambda: ("hotgauge/state", "offline") in broker.received, 10)


def test_a_broker_that_stays_away_is_a_fault_and_measuring_goes_on(tmp_path, monkeypatch):
    with rehearsing("fake_station", tmp_path, monkeypatch) as rehearsal:
        nobody = MqttSettings(host="127.0.0.1", port=free_port(), authority=tmp_path / "missing.pem")
        rehearsal.settings = rehearsal.settings.model_copy(update={"mqtt": nobody})
        rehearsal.supervisor = Supervisor(rehearsal.settings)
        rehearsal.start()
        with rehearsal.connect() as wire:
            assert wait_for(wire, lambda seen: seen["fault_word"] == BITS["delivery_failed"], 20)
            assert has_value(look(wire))


def line(number: int, table: str = "readings") -> RowLine:
    return RowLine(table=table, values={"exposed_utc_ms": 1_700_000_000_000 + number, "sequence": number})


def test_messages_that_wait_are_bounded_and_readings_are_given_up_first(broker):
    broker.stop()
    sender = MqttSender(settings(broker, waiting_max=200))
    for number in range(150):
        sender.put(line(number))
    assert (sender.waiting, sender.dropped) == (100, 50)
    for number in range(150):
        sender.put(RowLine(table="faults", values={"came_utc_ms": 1_700_000_000_000 + number, "name": "camera_lost"}))
    assert (sender.waiting, sender.dropped) == (200, 100)
    broker.start()
    assert broker.wait_for(lambda: sender.waiting == 0, 20)
    assert broker.wait_for(lambda: len(broker.rows("faults")) == 100, 10)
    assert [row["sequence"] for row in broker.rows("readings")] == list(range(100))
    sender.close()


# paho lets go of the socket of a handshake that failed without closing it
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("why", ["stranger", "plain"])
def test_a_broker_that_cannot_prove_itself_gets_nothing(broker, tmp_path, why, monkeypatch):
    monkeypatch.setattr(mqtt, "OUTAGE_S", 1.0)
    other = Broker(tmp_path, free_port())
    wrong = {"authority": other.folder / "authority.pem"} if why == "stranger" else {"tls": False}
    sender = MqttSender(settings(broker, **wrong))
    sender.put(line(1))
    assert broker.wait_for(lambda: f"127.0.0.1:{broker.port}" in sender.trouble, 10)
    assert sender.waiting == 1
    assert broker.received == []
    sender.close()
