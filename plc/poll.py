"""Reads a gauge as a PLC does, on pymodbus, and shows what it read in words."""

import contextlib
import logging
import socket
import ssl
import struct
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime

from pymodbus import ModbusException
from pymodbus.client import ModbusTcpClient
from pymodbus.pdu import ModbusPDU

from plc.codes import CODES, Bits, NamedBit, Orientation
from plc.process_image import decode, decode_discretes, decode_set_points
from plc.registers import BARS, DISCRETES, MEASUREMENTS, REGISTERS, SET_POINTS
from plc.rows import WordOrder, select
from plc.security.identity import TlsFiles

# PollError says it in one sentence; without a handler the library would print its own beside it
logging.getLogger("pymodbus").addHandler(logging.NullHandler())
ANSWER_WITHIN_S = 2.0
_ALARMS = [row for row in select(REGISTERS, "coil", "r") if not row.spare]
_UNITS = {row.name: row.unit for row in REGISTERS}
_TEST_U32 = next(row.constant for row in REGISTERS if row.name == "test_u32")
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
    "deviation",
    "correction",
    "bar_sequence",
    "bar_min",
    "bar_mean",
    "bar_max",
    "clients_refused",
)
_ALL = [row.name for row in select(REGISTERS, "input", "r", "measurement") if not row.spare and row.name not in CODES]
_SET_POINT_ROWS = {row.name: row for row in select(REGISTERS, "holding", "rw")}
_BIT_WORDS = {"reason_word": "reason", "fault_word": "fault", "ingot_reason_word": "ingot reason"}
_NO_BITS: Bits = {}


class PollError(Exception):
    """The gauge does not answer as a gauge should; the message says where, what and what to do."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a gauge is, and how it is read.

    Attributes
    ----------
    host : str
        Name or address of the gauge.
    port : int
        TCP port of its Modbus server, or of Modbus/TCP Security.
    word_order : {"big", "little"}
        As set in the gauge.
    tls : TlsFiles or None
        The client's own certificate and key, and the gauge's authority; None for the port without TLS.
    """

    host: str
    port: int = 502
    word_order: WordOrder = "big"
    tls: TlsFiles | None = None

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


class _SecureClient(ModbusTcpClient):
    """Modbus/TCP Security; the client of the library names no host in its handshake, so it checks none."""

    def __init__(self, place: Place, files: TlsFiles) -> None:
        super().__init__(place.host, port=place.port, timeout=ANSWER_WITHIN_S, retries=0)
        self._place = place
        self._files = files

    def connect(self) -> bool:
        """Connect and shake hands, unless that was done; whether both have succeeded."""
        if self.connected:
            return True
        try:
            context = ssl.create_default_context(cafile=self._files.authority)
            context.load_cert_chain(self._files.certificate, self._files.key)
            plain = socket.create_connection((self._place.host, self._place.port), timeout=ANSWER_WITHIN_S)
            self.socket = context.wrap_socket(plain, server_hostname=self._place.host)
        except OSError:
            self.close()
        return self.connected


def connect(place: Place) -> ModbusTcpClient:
    """Client that is connected; the caller closes it.

    Raises
    ------
    PollError
        Nobody listens there, or certificates do not fit.
    """
    plain = ModbusTcpClient(place.host, port=place.port, timeout=ANSWER_WITHIN_S, retries=0)
    client = plain if place.tls is None else _SecureClient(place, place.tls)
    if not client.connect():
        if not _is_known(place.host):
            raise PollError(f"{place.host}: no host of this name is known here; check the name, or give an address")
        more = "" if place.tls is None else ", and the certificates"
        raise PollError(f"{place}: nobody answers; check the address, the port and that the gauge runs{more}")
    return client


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
        Time that all requests took.
    set_points : dict of str to float, int or None
        What the PLC has written, in the units of the map; None for what is not set.
    words, set_point_words : tuple of int
        Words of the measurement block and of the set points, as they were on the wire.
    bars : dict of str to float, int or None
        The block of bars side by side, in the units of the map; None for no value. It is read after the measurement
        block, so it may be of a later moment.
    bar_words : tuple of int
        Its words.
    """

    values: dict[str, float | int | None]
    discretes: dict[str, bool]
    elapsed_ms: float
    set_points: dict[str, float | int | None] = field(default_factory=dict[str, "float | int | None"])
    words: tuple[int, ...] = ()
    set_point_words: tuple[int, ...] = ()
    bars: dict[str, float | int | None] = field(default_factory=dict[str, "float | int | None"])
    bar_words: tuple[int, ...] = ()

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
    place = Place(host, port, word_order)
    with contextlib.closing(connect(place)) as client:
        due = time.monotonic()
        while True:
            yield scan(client, str(place), word_order)
            due = max(due + every_s, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))


def connection_lost(place: str) -> str:
    """What to say of a connection that was closed in the middle, as a port with TLS does to who has no certificate."""
    return f"{place}: connection lost; check that the gauge runs, that the port is the plain one, or the certificate"


def _is_known(host: str) -> bool:
    try:
        socket.getaddrinfo(host, None)
    except socket.gaierror:
        return False
    return True


def scan(client: ModbusTcpClient, place: str, word_order: WordOrder) -> Snapshot:
    """One poll of everything: the blocks, the bits, the set points; raises `PollError`."""
    begun = time.monotonic()
    try:
        block = client.read_input_registers(MEASUREMENTS.start, count=len(MEASUREMENTS))
        bits = client.read_discrete_inputs(DISCRETES.start, count=len(DISCRETES))
        written = client.read_holding_registers(SET_POINTS.start, count=len(SET_POINTS))
        several = client.read_input_registers(BARS.start, count=len(BARS))
    except (ModbusException, OSError) as error:
        raise PollError(connection_lost(place)) from error
    for answer in (block, bits, written, several):
        _refuse_exception(answer, place)
    elapsed_ms = 1000 * (time.monotonic() - begun)
    try:
        numbers = decode_set_points(struct.pack(f">{len(SET_POINTS)}H", *written.registers), word_order=word_order)
        values, discretes = decode(block.registers, word_order=word_order), decode_discretes(bits.bits)
        side_by_side = decode(several.registers, block="bars", word_order=word_order)
    except (ValueError, struct.error) as error:
        raise PollError(f"{place}: answers with less than was asked for; check that this is a gauge") from error
    return Snapshot(
        values,
        discretes,
        elapsed_ms,
        {name: _SET_POINT_ROWS[name].to_value(number) or None for name, number in numbers.items()},
        tuple(block.registers),
        tuple(written.registers),
        side_by_side,
        tuple(several.registers),
    )


def _refuse_exception(answer: ModbusPDU, place: str) -> None:
    if answer.isError():
        code = answer.exception_code
        raise PollError(f"{place}: answers Modbus exception {code}; check that this is a gauge of this version")


def snapshot_lines(snapshot: Snapshot, bits: Bits = _NO_BITS, *, everything: bool = False) -> list[str]:
    """Render a snapshot as lines for people.

    Parameters
    ----------
    snapshot : Snapshot
    bits : mapping of str to sequence of NamedBit
        Names of the bits of `reason_word`, `ingot_reason_word` and `fault_word`; without: their numbers.
    everything : bool
        Every row of the measurement block, and not only what people look at.

    Returns
    -------
    list of str
    """
    if not snapshot.word_order_fits:
        return ["the test value reads wrongly: this is not a gauge, or the word order is the other one"]
    values = snapshot.values
    exposed = values["timestamp"]
    states = [name for name, on in snapshot.discretes.items() if on and not name.startswith("alarm_")]
    lines = [
        f"{'sequence':<26}{values['sequence']}, heartbeat {values['heartbeat']}",
        _code_line("device_state", values["device_state"]),
        f"{_code_line('validity', values['validity'])}, reasons {int(values['reason_word'] or 0):#010x}",
        _code_line("decision", values["decision"]),
        *_bit_lines(snapshot, bits),
        *(_line(name, values[name]) for name in (_ALL if everything else _SHOWN)),
        *_ingot_lines(values),
        *(_line(name, value) for name, value in snapshot.set_points.items()),
        f"{'timestamp':<26}{'no value' if exposed is None else _utc(exposed)}",
        f"{'states':<26}{', '.join(states) or 'none'}",
        f"{'alarms':<26}{', '.join(snapshot.alarms) or 'none'}",
        f"{'answered in':<26}{snapshot.elapsed_ms:.1f} ms",
    ]
    return lines if snapshot.whole else [*lines, "torn: the first and the last word of the block differ"]


def to_record(snapshot: Snapshot, bits: Bits = _NO_BITS) -> dict[str, object]:
    """A snapshot for programs: values by register, and what is on by name.

    Parameters
    ----------
    snapshot : Snapshot
    bits : mapping of str to sequence of NamedBit
        As for `snapshot_lines`.
    """
    return {
        "values": snapshot.values,
        "set_points": snapshot.set_points,
        "states": [name for name, on in snapshot.discretes.items() if on and not name.startswith("alarm_")],
        "alarms": snapshot.alarms,
        **{word: [named.name for named in _set_bits(snapshot, word, bits)] for word in _BIT_WORDS},
        "whole": snapshot.whole,
        "elapsed_ms": round(snapshot.elapsed_ms, 3),
    }


def _set_bits(snapshot: Snapshot, word: str, bits: Bits) -> list[NamedBit]:
    number = int(snapshot.values[word] or 0)
    named = {one.bit: one for one in bits.get(word, ())}
    on = [bit for bit in range(number.bit_length()) if number >> bit & 1]
    return [named.get(bit, NamedBit(bit, f"bit {bit}", "")) for bit in on]


def _bit_lines(snapshot: Snapshot, bits: Bits) -> list[str]:
    lines: list[str] = []
    for word, title in _BIT_WORDS.items():
        on = _set_bits(snapshot, word, bits)
        lines += [f"{title:<26}{one.name}{': ' if one.text else ''}{one.text}" for one in on]
    return lines


def _ingot_lines(values: Mapping[str, float | int | None]) -> list[str]:
    if not values["ingot_orientation"]:
        return []
    confidence = values["ingot_confidence"] or 0
    seen = f"{values['ingot_sequence']}, {Orientation(int(values['ingot_orientation'])).text}, {confidence:.2f} %"
    return [f"{'ingot':<26}{seen}"]


def _line(name: str, value: float | None) -> str:
    return f"{name:<26}{value_in_words(name, value)}"


def value_in_words(name: str, value: float | None) -> str:
    """Value of a register for people: with its unit, or with the words of its code.

    Parameters
    ----------
    name : str
        Register.
    value : float, int or None
        In the unit of the map; None for no value.
    """
    if value is None:
        return "no value"
    if name in CODES:
        return _code_in_words(name, value)
    number = f"{value:.3f}" if isinstance(value, float) else str(value)
    return f"{number} {_UNITS[name]}".rstrip()


def _code_in_words(name: str, code: float | None) -> str:
    text = CODES[name].texts().get(int(code or 0), "unknown to this version")
    return f"{code} {'no value' if name == 'validity' and not code else text}"


def _code_line(name: str, code: float | None) -> str:
    return f"{name:<26}{_code_in_words(name, code)}"


def _utc(since_1970_ms: float) -> str:
    return datetime.fromtimestamp(since_1970_ms / 1000, UTC).isoformat(sep=" ", timespec="milliseconds")
