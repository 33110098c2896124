"""Sends rows to an MQTT broker, at least once each (QoS 1); while it is away they wait in memory, up to a limit."""

import contextlib
import importlib
import json
import threading
import time
from datetime import datetime
from typing import Any

from appliance.cameras.stream.address import read_credentials
from appliance.delivery.message import RowLine
from appliance.delivery.settings import MqttSettings
from appliance.errors import HotgaugeError
from appliance.history.export import exported
from appliance.history.tables import TABLES

IN_FLIGHT_MAX = 20  # messages sent and not acknowledged
RECONNECT_S = (1, 30)  # first and longest pause
KEEP_ALIVE_S = 30
OUTAGE_S = 30.0  # chosen: a broker that is away for longer is a fault
LEAVE_TIME_S = 1.0

_TABLES = {table.name: table for table in TABLES}


def payload(line: RowLine) -> str:
    """A row as JSON: the columns of `hotgauge export`, times in ISO 8601."""
    table = _TABLES[line.table]
    values = exported(table, {column.name: line.values.get(column.name) for column in table.columns})
    return json.dumps({name: _in_json(value) for name, value in values.items()}, ensure_ascii=False)


def _in_json(value: object) -> object:
    if isinstance(value, datetime):
        return value.isoformat(timespec="milliseconds").replace("+00:00", "Z")
    return value


class MqttSender:
    """The connection to a broker; paho's own thread sends, resends and reconnects.

    Parameters
    ----------
    settings : MqttSettings

    Attributes
    ----------
    waiting : int
        Messages that the broker has not acknowledged.
    dropped : int
        Messages given up because too many waited.
    """

    def __init__(self, settings: MqttSettings) -> None:
        self.waiting = self.dropped = 0
        self._settings = settings
        self._lock = threading.Lock()
        self._client: Any = None
        self._wrong = ""
        self._refused = ""
        self._away_since_s: float | None = time.monotonic()
        try:
            self._client = self._start()
        except ImportError:
            self._wrong = "mqtt: paho-mqtt is missing; pip install 'hotgauge[mqtt]'"
        except (HotgaugeError, OSError, ValueError) as error:
            self._wrong = f"mqtt: {error}; check the files that mqtt names"

    def _start(self) -> Any:
        paho: Any = importlib.import_module("paho.mqtt.client")
        settings = self._settings
        client = paho.Client(paho.CallbackAPIVersion.VERSION2, client_id=settings.client)
        if settings.credentials is not None:
            client.username_pw_set(*read_credentials(settings.credentials))
        if settings.tls:
            client.tls_set(
                *(
                    None if path is None else str(path)
                    for path in (settings.authority, settings.certificate, settings.key)
                )
            )
        client.max_inflight_messages_set(IN_FLIGHT_MAX)
        client.max_queued_messages_set(0)  # `put` limits them
        client.reconnect_delay_set(*RECONNECT_S)
        client.will_set(self._topic("state"), "offline", qos=1, retain=True)
        client.on_connect, client.on_disconnect, client.on_publish = self._connected, self._lost, self._acknowledged
        client.connect_async(settings.host, settings.port, KEEP_ALIVE_S)
        client.loop_start()
        return client

    def _topic(self, name: str) -> str:
        return f"{self._settings.topic}/{name}"

    @property
    def trouble(self) -> str:
        """Why nothing is sent; empty while it is, and during the first `OUTAGE_S` of an outage."""
        away_s = 0.0 if self._away_since_s is None else time.monotonic() - self._away_since_s
        if self._wrong or away_s < OUTAGE_S:
            return self._wrong
        place = f"mqtt: {self._settings.host}:{self._settings.port}"
        return (
            f"{place}: {self._refused or 'no broker answers'}; {self.waiting} messages wait, check it and the network"
        )

    def put(self, line: RowLine) -> None:
        """Send a row, or keep it until it can be sent; one too many is dropped and counted, readings first."""
        limit = self._settings.waiting_max // (2 if line.table == "readings" else 1)
        if self._client is None or self.waiting >= limit:
            self.dropped += 1
            return
        with self._lock:
            self.waiting += 1
        self._client.publish(self._topic(line.table), payload(line), qos=1)

    def close(self) -> None:
        """Say that the gauge is off, and end; what still waits is lost."""
        if self._client is None:
            return
        if self._away_since_s is None:
            with contextlib.suppress(ValueError, RuntimeError):
                self._client.publish(self._topic("state"), "offline", qos=1, retain=True).wait_for_publish(LEAVE_TIME_S)
        self._client.disconnect()
        self._client.loop_stop()

    def _connected(self, client: Any, _data: object, _flags: object, reason: Any, _properties: object) -> None:
        if reason.is_failure:
            self._refused = f"the broker refuses: {reason}"
            return
        self._refused = ""
        self._away_since_s = None
        with self._lock:
            self.waiting += 1
        client.publish(self._topic("state"), "online", qos=1, retain=True)

    def _lost(self, _client: Any, _data: object, _flags: object, _reason: object, _properties: object) -> None:
        self._away_since_s = self._away_since_s or time.monotonic()

    def _acknowledged(self, _client: Any, _data: object, _mid: int, _reason: object, _properties: object) -> None:
        with self._lock:
            self.waiting -= 1
