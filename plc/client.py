"""A PLC in miniature: reads and writes the gauge as a mill's PLC does, for commissioning and for tests."""

import contextlib
import struct
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Self

from pymodbus import ModbusException
from pymodbus.client import ModbusTcpClient

from plc.codes import Orientation
from plc.poll import ANSWER_WITHIN_S, Place, PollError, Snapshot, connect, connection_lost, scan
from plc.process_image import encode_set_points
from plc.registers import COMMANDS, REGISTERS, SET_POINTS
from plc.rows import WordOrder, select

_HEARTBEAT_WITHIN_S = 1.0
_COMMANDS = {row.name: row.address for row in select(REGISTERS, "coil", "rw")}
_SET_POINTS = {row.name: row for row in select(REGISTERS, "holding", "rw")}


class WriteRefusedError(PollError):
    """The gauge does not let this client write."""


def press(place: Place, command: str) -> None:
    """Give a command as a person with a button does: 1, and 0 again.

    Parameters
    ----------
    place : Place
    command : str
        Coil of the register map, as `acknowledge`.

    Raises
    ------
    WriteRefusedError
        Setting, address or certificate do not permit it.
    PollError
        The gauge does not answer.
    """
    with contextlib.closing(connect(place)) as client:
        for level in (True, False):
            try:
                answer = client.write_coil(_COMMANDS[command], level)
            except (ModbusException, OSError) as error:
                raise PollError(connection_lost(str(place))) from error
            if answer.isError():
                advice = "check plc.writes, plc.writers and the role in the certificate"
                raise WriteRefusedError(f"{place}: refuses {command}, exception {answer.exception_code}; {advice}")


@dataclass(slots=True)
class Outputs:
    """What the PLC's program wants; all of it is written with every scan, changed or not.

    Attributes
    ----------
    set_points : dict of str to float
        By name, in the unit of the map; what is missing is written as 0, not set.
    hold : bool
    beats : bool
        Whether `plc_heartbeat` counts on.
    """

    set_points: dict[str, float] = field(default_factory=dict[str, float])
    hold: bool = False
    beats: bool = True


@dataclass(slots=True)
class _Seen:
    """What the program made of the last scan."""

    valid: bool = False
    bar: float = 0
    ingot: float = 0
    alarms: list[str] = field(default_factory=list[str])
    refused: set[int] = field(default_factory=set[int])
    heartbeat: float | None = None
    moved_s: float = 0.0
    alive: bool = True


class Plc:
    """A PLC that rewrites all its outputs in every scan, watches the gauge and logs what happens.

    Parameters
    ----------
    host : str
    port : int
    word_order : {"big", "little"}
        As set in the gauge.

    Attributes
    ----------
    outputs : Outputs
        To be changed by the program between two scans.
    log : list of str
        One line for each event: connection, validity, bar, ingot, alarms, refused requests.
    """

    def __init__(self, host: str, port: int = 502, *, word_order: WordOrder = "big") -> None:
        self.outputs = Outputs()
        self.log: list[str] = []
        self._place = f"{host}:{port}"
        self._word_order: WordOrder = word_order
        self._client = ModbusTcpClient(host, port=port, timeout=ANSWER_WITHIN_S, retries=0)
        self._connected = False
        self._pressed = False
        self._beat = 0
        self._seen = _Seen()

    def __enter__(self) -> Self:
        """Nothing happens before the first scan."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the connection."""
        self._client.close()

    def run(self, until: Callable[[Snapshot], bool], within_s: float, *, every_s: float = 0.05) -> Snapshot:
        """Scan until what has been read is as wanted.

        Parameters
        ----------
        until : callable
            Judges each snapshot.
        within_s : float
        every_s : float
            Time from scan to scan; PLCs have 0.01 to 0.1.

        Returns
        -------
        Snapshot
            The first that is as wanted.

        Raises
        ------
        TimeoutError
            None was in time.
        """
        due_s = begun_s = time.monotonic()
        while due_s - begun_s < within_s:
            snapshot = self.scan()
            if snapshot is not None and until(snapshot):
                return snapshot
            due_s = max(due_s + every_s, time.monotonic())
            time.sleep(max(0.0, due_s - time.monotonic()))
        raise TimeoutError(f"{self._place}: not seen within {within_s:g} s; log: {self.log}")

    def press_acknowledge(self) -> None:
        """Set `acknowledge` for the next scan only."""
        self._pressed = True
        self.log.append(f"acknowledged {', '.join(self._seen.alarms) or 'nothing'}")

    def scan(self) -> Snapshot | None:
        """Write all outputs, read all inputs, log what has changed; None when the gauge does not answer."""
        try:
            self._connect()
            self._write()
            snapshot = scan(self._client, self._place, self._word_order)
        except PollError:
            self._lose()
            return None
        self._compare(snapshot, time.monotonic())
        return snapshot

    def _connect(self) -> None:
        if self._connected:
            return
        if not self._client.connect():
            raise PollError(f"{self._place}: nobody answers")
        self._connected = True
        self._seen.moved_s = time.monotonic()
        self.log.append("connected")

    def _lose(self) -> None:
        self._client.close()
        if self._connected:
            self._connected = False
            self.log.append("connection lost")
            self._see_valid(now=False)

    def _write(self) -> None:
        self._beat = (self._beat + self.outputs.beats) & 0xFFFF
        set_points = self.outputs.set_points | {"plc_heartbeat": self._beat}
        numbers = {name: round(value / _SET_POINTS[name].scale) for name, value in set_points.items()}
        data = encode_set_points(numbers, word_order=self._word_order)
        words = list(struct.unpack(f">{len(SET_POINTS)}H", data))
        try:
            answers = (
                self._client.write_registers(SET_POINTS.start, words),
                self._client.write_coils(COMMANDS.start, [self._pressed, self.outputs.hold]),
            )
        except (ModbusException, OSError) as error:
            raise PollError(f"{self._place}: connection lost") from error
        self._pressed = False
        refused = {answer.exception_code for answer in answers if answer.isError()}
        self.log += [f"write refused with exception {code}" for code in sorted(refused - self._seen.refused)]
        self._seen.refused = refused

    def _compare(self, snapshot: Snapshot, now_s: float) -> None:
        values, seen = snapshot.values, self._seen
        if values["heartbeat"] != seen.heartbeat:
            seen.heartbeat, seen.moved_s = values["heartbeat"], now_s
        alive = now_s - seen.moved_s < _HEARTBEAT_WITHIN_S
        if alive != seen.alive:
            self.log.append("heartbeat moves" if alive else "heartbeat stands still")
            seen.alive = alive
        self._see_valid(now=alive and values["validity"] != 0)
        bar = values["bar_sequence"] or 0
        if bar not in (0, seen.bar):
            self.log.append(f"bar {bar}")
        seen.bar = bar
        self._see_ingot(values)
        self._see_alarms(snapshot.alarms)

    def _see_valid(self, *, now: bool) -> None:
        if now != self._seen.valid:
            self.log.append("measurement valid" if now else "measurement not valid")
            self._seen.valid = now

    def _see_ingot(self, values: Mapping[str, float | int | None]) -> None:
        ingot = values["ingot_sequence"] or 0
        if values["ingot_validity"] and ingot != self._seen.ingot:
            self._seen.ingot = ingot
            self.log.append(f"ingot {ingot} shows its {Orientation(int(values['ingot_orientation'] or 0)).text}")

    def _see_alarms(self, now: list[str]) -> None:
        self.log += [f"{name} came" for name in now if name not in self._seen.alarms]
        self.log += [f"{name} went" for name in self._seen.alarms if name not in now]
        self._seen.alarms = now
