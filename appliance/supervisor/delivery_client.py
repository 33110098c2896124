"""The supervisor's side of the process that delivers: rows and figures in, its trouble out."""

import time
from collections import deque
from collections.abc import Mapping

from appliance.delivery.message import MESSAGES, DeliveryStatus, FiguresLine, RowLine, without_nan
from appliance.delivery.settings import DeliverySettings
from appliance.diagnostics.alarms import Alarms
from appliance.diagnostics.faults import Faults
from appliance.history.tables import Row
from appliance.processes.message import StateMessage
from appliance.processes.monitored_process import Health, MonitoredProcess
from plc.rows import Value

MODULE = "appliance.delivery.process"
FAULT = "delivery_failed"
FIGURES_PERIOD_S = 1.0
ROWS_WAITING_MAX = 5000  # rows, about 5 MB, while the process starts or its link is full


class DeliveryClient:
    """What leaves the gauge beside the PLC; never waits.

    Parameters
    ----------
    settings : DeliverySettings
    faults : Faults
    """

    def __init__(self, settings: DeliverySettings, faults: Faults) -> None:
        self._dropped = 0
        self._faults = faults
        self._process = MonitoredProcess(
            MODULE, settings.model_dump_json(), MESSAGES, self._receive, self._receive_health
        )
        self._waiting: deque[bytes] = deque()
        self._figures_s = -FIGURES_PERIOD_S
        self._hears = False

    async def run(self) -> None:
        """Keep the process running until cancelled."""
        await self._process.run()

    def put(self, row: Row) -> None:
        """Deliver a row; one too many is dropped and counted (`hotgauge_rows_dropped_total`)."""
        if len(self._waiting) >= ROWS_WAITING_MAX:
            self._dropped += 1
            return
        self._waiting.append(RowLine.of(row).model_dump_json().encode())
        self._send_waiting()

    def put_figures(self, values: Mapping[str, Value], alarms: Alarms) -> None:
        """Deliver what the registers say now, at most once in `FIGURES_PERIOD_S`.

        Parameters
        ----------
        values : mapping of str to value
            By name of the register.
        alarms : Alarms
        """
        self._send_waiting()
        now_s = time.monotonic()
        if now_s - self._figures_s < FIGURES_PERIOD_S:
            return
        self._figures_s = now_s
        figures = FiguresLine(
            values=without_nan(values),
            faults=tuple(self._faults.active),
            alarms=tuple(alarms.active),
            rows_dropped=self._dropped,
        )
        if self._hears:
            self._process.send(figures.model_dump_json().encode())

    def _send_waiting(self) -> None:
        while self._hears and self._waiting and self._process.send(self._waiting[0]):
            self._waiting.popleft()

    def _receive(self, message: StateMessage | DeliveryStatus) -> None:
        if isinstance(message, DeliveryStatus):
            self._hears = True
            self._faults.report(FAULT, active=bool(message.trouble), detail=message.trouble)

    def _receive_health(self, health: Health) -> None:
        self._hears = self._hears and not health.ended
        if health.state == "failing":
            self._faults.report(FAULT, active=True, detail=health.detail)
