"""A PLC in miniature: reads and writes the gauge as a mill's PLC does, for commissioning and for tests."""

import logging
import struct
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Self

from pymodbus import ModbusException
from pymodbus.client import ModbusTcpClient
from pymodbus.pdu import ModbusPDU

from plc.registers import (
    COMMANDS,
    DISCRETES,
    MEASUREMENTS,
    REGISTERS,
    SET_POINTS,
    WordOrder,
    decode,
    decode_discretes,
    encode_set_points,
)
from plc.rows import select

# PollError says it in one sentence; without a handler the library would print its own beside it
logging.getLogger("pymodbus").addHandler(logging.NullHandler())

_ANSWER_WITHIN_S = 2.0
_HEARTBEAT_WITHIN_S = 1.0
_ALARMS = [row for row in select(REGISTERS, "coil", "r") if not row.spare]
_SET_POINTS = {row.name: row for row in select(REGISTERS, "holding", "rw")}
_UNITS = {row.name: row.unit for row in REGISTERS}
_TEST_U32 = next(row.constant for row in REGISTERS if row.name == "test_u32")
_VALIDITY = {0: "no value", 1: "valid", 2: "valid with reasons"}
_DEVICE_STATES = {
    0: "good",
    1: "maintenance required",
    2: "out of specification",
    3: "function check",
    4: "failure",
}
_ORIENTATIONS = {1: "top", 2: "bottom", 3: "undecided"}
_SHOWN = (
    "diameter",
    "expanded_uncertainty",
    "trust",
    "diameter_cold",
    "diameter_virtual_board",
    "measurement_age",
    "cycle_time",
    "windows_kept",
    "windows_total",
    "frames_dropped",
)


class PollError(Exception):
    """The gauge does not answer as a gauge should; the message says where, what and what to do."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What one scan has read.

    Attributes
    ----------
    values : dict of str to float, int or None
        The measurement block in the units of the map; None for no value.
    discretes : dict of str to bool
        Alarms and states.
    elapsed_ms : float
        Time that both requests took.
    """

    values: dict[str, float | int | None]
    discretes: dict[str, bool]
    elapsed_ms: float

    @property
    def whole(self) -> bool:
        """Whether the block's first and last word agree, so that all words are of one moment."""
        return self.values["sequence"] == self.values["sequence_check"]

    @property
    def word_order_fits(self) -> bool:
        """Whether the test value reads as it should."""
        return self.values["test_u32"] == _TEST_U32

    @property
    def alarms(self) -> list[str]:
        """Names of the alarms that are on, from the block: bits are read by a request and at a moment of their own."""
        word = int(self.values["alarm_word"] or 0)
        return [row.name for row in _ALARMS if word >> row.address & 1]


def poll(host: str, port: int = 502, *, every_s: float = 1.0, word_order: WordOrder = "big") -> Iterator[Snapshot]:
    """Read the gauge again and again, until the iterator is closed.

    Parameters
    ----------
    host : str
        Name or address of the gauge.
    port : int
        TCP port of its Modbus server.
    every_s : float
        Time from scan to scan.
    word_order : {"big", "little"}
        As set in the gauge.

    Yields
    ------
    Snapshot

    Raises
    ------
    PollError
        Nobody listens there, the connection was lost, or the answer was an exception.
    """
    with ModbusTcpClient(host, port=port, timeout=_ANSWER_WITHIN_S, retries=0) as client:
        if not client.connected:
            raise PollError(f"{host}:{port}: nobody answers; check the address, the port and that the gauge runs")
        due = time.monotonic()
        while True:
            yield _scan(client, f"{host}:{port}", word_order)
            due = max(due + every_s, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))


def _scan(client: ModbusTcpClient, place: str, word_order: WordOrder) -> Snapshot:
    begun = time.monotonic()
    try:
        block = client.read_input_registers(MEASUREMENTS.start, count=len(MEASUREMENTS))
        bits = client.read_discrete_inputs(DISCRETES.start, count=len(DISCRETES))
    except (ModbusException, OSError) as error:
        raise PollError(f"{place}: connection lost; check that the gauge runs ({error})") from error
    for answer in (block, bits):
        _refuse_exception(answer, place)
    elapsed_ms = 1000 * (time.monotonic() - begun)
    return Snapshot(decode(block.registers, word_order=word_order), decode_discretes(bits.bits), elapsed_ms)


def _refuse_exception(answer: ModbusPDU, place: str) -> None:
    if answer.isError():
        code = answer.exception_code
        raise PollError(f"{place}: answers Modbus exception {code}; check that this is a gauge of this version")


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
        self._client = ModbusTcpClient(host, port=port, timeout=_ANSWER_WITHIN_S, retries=0)
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
            snapshot = _scan(self._client, self._place, self._word_order)
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
            self.log.append(f"ingot {ingot} shows its {_ORIENTATIONS[int(values['ingot_orientation'] or 0)]}")

    def _see_alarms(self, now: list[str]) -> None:
        self.log += [f"{name} came" for name in now if name not in self._seen.alarms]
        self.log += [f"{name} went" for name in self._seen.alarms if name not in now]
        self._seen.alarms = now


def snapshot_lines(snapshot: Snapshot) -> list[str]:
    """Render a snapshot as lines for people.

    Parameters
    ----------
    snapshot : Snapshot

    Returns
    -------
    list of str
    """
    if not snapshot.word_order_fits:
        return ["the test value reads wrongly: this is not a gauge, or the word order is the other one"]
    values = snapshot.values
    exposed = values["timestamp"]
    reasons = int(values["reason_word"] or 0)
    states = [name for name, on in snapshot.discretes.items() if on and not name.startswith("alarm_")]
    lines = [
        f"{'sequence':<26}{values['sequence']}, heartbeat {values['heartbeat']}",
        f"{'device_state':<26}{_named(values['device_state'], _DEVICE_STATES)}",
        f"{'validity':<26}{_named(values['validity'], _VALIDITY)}, reasons {reasons:#010x}",
        *(_line(name, values[name]) for name in _SHOWN),
        *_ingot_lines(values),
        f"{'timestamp':<26}{'no value' if exposed is None else _utc(exposed)}",
        f"{'states':<26}{', '.join(states) or 'none'}",
        f"{'alarms':<26}{', '.join(snapshot.alarms) or 'none'}",
        f"{'answered in':<26}{snapshot.elapsed_ms:.1f} ms",
    ]
    return lines if snapshot.whole else [*lines, "torn: the first and the last word of the block differ"]


def _ingot_lines(values: Mapping[str, float | int | None]) -> list[str]:
    if not values["ingot_orientation"]:
        return []
    confidence = values["ingot_confidence"] or 0
    seen = f"{values['ingot_sequence']}, {_ORIENTATIONS[int(values['ingot_orientation'])]}, {confidence:.2f} %"
    return [f"{'ingot':<26}{seen}"]


def _line(name: str, value: float | None) -> str:
    if value is None:
        return f"{name:<26}no value"
    number = f"{value:.3f}" if isinstance(value, float) else str(value)
    return f"{name:<26}{number} {_UNITS[name]}".rstrip()


def _named(code: float | None, names: dict[int, str]) -> str:
    return f"{code} {names.get(int(code or 0), 'unknown')}"


def _utc(since_1970_ms: float) -> str:
    return datetime.fromtimestamp(since_1970_ms / 1000, UTC).isoformat(sep=" ", timespec="milliseconds")
