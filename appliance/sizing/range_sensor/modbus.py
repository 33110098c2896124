"""A laser's range, read again and again over Modbus TCP by a thread of its own."""

import contextlib
import math
import threading
import time
from collections import deque
from collections.abc import Sequence
from typing import Self, cast

from pymodbus import ModbusException
from pymodbus.client import ModbusTcpClient

from appliance.sizing.range_sensor.sensor import Exposed, RangeReading, steady_range_mm, with_range
from appliance.sizing.range_sensor.settings import ModbusRange

ANSWER_WITHIN_S = 0.5  # chosen: a sensor answers within some milliseconds
LOST_AFTER_S = 1.0  # chosen: time without an answer after which the sensor counts as lost
RETRY_PAUSE_S = 0.5  # chosen: before a connection is tried again
KEPT_READINGS = 256  # 5 s at the usual period
READS_WITHIN_AGE = 2.5  # of `age_max_ms`: two before each exposure show whether the bar holds still
LEAVE_TIME_S = 2 * ANSWER_WITHIN_S


class ModbusRangeSensor:
    """Reads the range until it is closed, and connects again after every trouble; see `RangeSensor`.

    Parameters
    ----------
    settings : ModbusRange
    """

    def __init__(self, settings: ModbusRange) -> None:
        self._settings = settings
        self._readings: deque[RangeReading] = deque(maxlen=KEPT_READINGS)
        self._trouble = "has not answered yet"
        self._answered_s = -math.inf
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._read_until_closed, daemon=True)

    def __enter__(self) -> Self:
        """Start reading."""
        self._answered_s = time.monotonic()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop reading."""
        self._closed.set()
        self._thread.join(LEAVE_TIME_S)

    @property
    def faults(self) -> dict[str, str]:
        """`range_lost` while the sensor does not answer as it should."""
        if time.monotonic() - self._answered_s <= LOST_AFTER_S:
            return {}
        return {"range_lost": f"{self._settings.host}:{self._settings.port}: {self._trouble}"}

    def beside(self, exposed: Exposed) -> Exposed:
        """The exposure with the range of its moment."""
        readings, age_max_s = list(self._readings), self._settings.age_max_ms / 1000
        range_mm = steady_range_mm(readings, exposed.exposed_monotonic_s, age_max_s, self._settings.u_mm)
        return with_range(exposed, range_mm)

    def _read_until_closed(self) -> None:
        settings = self._settings
        while not self._closed.is_set():
            client = ModbusTcpClient(settings.host, port=settings.port, timeout=ANSWER_WITHIN_S, retries=0)
            with contextlib.closing(client):
                try:
                    if client.connect():
                        self._read_from(client)
                    else:
                        self._trouble = "nobody answers"
                except (ModbusException, OSError) as error:
                    self._trouble = f"the connection is lost ({type(error).__name__})"
            self._closed.wait(RETRY_PAUSE_S)

    def _read_from(self, client: ModbusTcpClient) -> None:
        settings = self._settings
        read = client.read_input_registers if settings.table == "input" else client.read_holding_registers
        while not self._closed.wait(settings.age_max_ms / 1000 / READS_WITHIN_AGE):
            asked_s = time.monotonic()
            answer = read(settings.address, count=settings.words, device_id=settings.unit_id)
            answered_s = time.monotonic()
            if answer.isError() or len(answer.registers) != settings.words:
                self._trouble = f"refuses register {settings.address} of unit {settings.unit_id}"
                return
            self._answered_s = answered_s
            moment_s = 0.5 * (asked_s + answered_s)
            self._readings.append(RangeReading(moment_s, self._range_mm(answer.registers)))

    def _range_mm(self, words: Sequence[int]) -> float:
        kind = ModbusTcpClient.DATATYPE.UINT16 if len(words) == 1 else ModbusTcpClient.DATATYPE.UINT32
        count = cast("int", ModbusTcpClient.convert_from_registers(list(words), kind))
        range_mm = count * self._settings.scale_mm + self._settings.offset_mm
        least_mm, most_mm = self._settings.measures_mm
        return range_mm if least_mm <= range_mm <= most_mm else math.nan
