"""Figures for Prometheus: the registers of the measurement block, states, faults and alarms, from their tables.

A register without a value has no sample: a panel then shows a gap, and no alert compares a number that does not exist.
Figures older than FIGURES_AGE_MAX_S have none either: a supervisor that stands still shows no size that looks new.
"""

import importlib
import importlib.metadata
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from appliance.delivery.message import FiguresLine, Value
from appliance.delivery.settings import MetricsSettings
from appliance.diagnostics.alarms import ALARMS
from appliance.diagnostics.fault_table import FAULTS
from plc.registers import REGISTERS

# a gauge may not end in "_total", which is a counter's
UNIT_ENDINGS = {"mm": "_mm", "%": "_percent", "ms": "_ms", "°C": "_celsius", "": ""}
COUNTERS = ("frames_dropped", "clients_refused")
FIGURES_AGE_MAX_S = 5.0  # chosen: five periods; older figures are of a supervisor that stands still
FAULT_NAME, ALARM_NAME = "hotgauge_fault", "hotgauge_alarm"


class Figure(NamedTuple):
    """One figure: its name, the register that it shows, whether it only grows, and its text."""

    name: str
    register: str
    counts: bool
    text: str


def _figures() -> tuple[Figure, ...]:
    shown = [
        row
        for row in REGISTERS
        if row.constant is None
        and not row.shows
        and not row.name.startswith("spare")
        and (row.block == "measurement" or "discrete" in row.tables)
        and row.unit in UNIT_ENDINGS
    ]
    return tuple(
        Figure(
            f"hotgauge_{row.name.removesuffix('_total')}{UNIT_ENDINGS[row.unit]}",
            row.name,
            row.name in COUNTERS,
            row.text,
        )
        for row in shown
    )


FIGURES = _figures()


class Metrics:
    """The newest figures, read by the threads that answer Prometheus.

    Parameters
    ----------
    settings : MetricsSettings
    clock : callable
        Monotonic time, seconds.

    Attributes
    ----------
    mqtt_waiting, mqtt_dropped : int
        Of the MQTT sender.
    trouble : str
        Why nothing is served; empty while it is, or need not be.
    """

    def __init__(self, settings: MetricsSettings, clock: Callable[[], float] = time.monotonic) -> None:
        self.mqtt_waiting = self.mqtt_dropped = 0
        self.trouble = ""
        self._settings = settings
        self._clock = clock
        self._newest: FiguresLine | None = None
        self._newest_s = 0.0
        self._server: Any = None
        self._library: Any = None

    def update(self, figures: FiguresLine) -> None:
        """Have the next scrape see these."""
        self._newest_s, self._newest = self._clock(), figures

    def open(self) -> None:
        """Open the port unless it is open; `trouble` says why not."""
        if not self._settings.port or self._server is not None:
            return
        try:
            self._library = importlib.import_module("prometheus_client")
        except ImportError:
            self.trouble = "metrics: prometheus-client is missing; pip install 'hotgauge[metrics]'"
            return
        registry = self._library.CollectorRegistry(auto_describe=False)
        registry.register(self)
        try:
            self._server, _ = self._library.start_http_server(
                self._settings.port, addr=self._settings.host, registry=registry
            )
        except OSError as error:
            place = f"{self._settings.host}:{self._settings.port}"
            self.trouble = f"metrics: {place}: {error.strerror or error}; set metrics.host and metrics.port"
        else:
            self.trouble = ""

    @property
    def port(self) -> int:
        """TCP port that is served."""
        return self._server.server_port

    def close(self) -> None:
        """Close the port."""
        if self._server is not None:
            self._server.shutdown()
            self._server.server_close()

    def collect(self) -> Iterator[Any]:
        """All figures, as `prometheus_client` asks for them."""
        family = importlib.import_module("prometheus_client.core")
        newest = self._newest
        version = family.InfoMetricFamily("hotgauge", "version of the software")
        version.add_metric([], {"version": importlib.metadata.version("hotgauge")})
        yield version
        yield family.GaugeMetricFamily("hotgauge_mqtt_waiting", "messages that wait for the broker", self.mqtt_waiting)
        yield family.CounterMetricFamily("hotgauge_mqtt_dropped", "messages given up", self.mqtt_dropped)
        if newest is None:
            return
        rows = "rows given up before they reached the process that delivers"
        yield family.CounterMetricFamily("hotgauge_rows_dropped", rows, newest.rows_dropped)
        if self._clock() - self._newest_s > FIGURES_AGE_MAX_S:
            return
        for figure in FIGURES:
            number = _number(newest.values.get(figure.register))
            if number is not None:
                kind = family.CounterMetricFamily if figure.counts else family.GaugeMetricFamily
                yield kind(figure.name, figure.text, number)
        faults = family.GaugeMetricFamily(FAULT_NAME, "1 while a fault is active", labels=["fault"])
        for row in FAULTS:
            faults.add_metric([row.name], float(row.name in newest.faults))
        alarms = family.GaugeMetricFamily(ALARM_NAME, "1 while an alarm is active", labels=["alarm"])
        for row in ALARMS:
            alarms.add_metric([row.name], float(row.name in newest.alarms))
        yield from (faults, alarms)


def _number(value: Value) -> float | None:
    return None if value is None or isinstance(value, str) else float(value)
