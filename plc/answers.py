"""Answers to Modbus requests, from a process image and from what the PLC has written.

Rules after the Modbus Application Protocol V1.1b3. A request is checked in this order, and nothing is written
before all checks have passed: function and the client's right to it (exception 1), quantity and values (3), range (2),
act (4).

Tools of plants read aligned blocks that begin or end between rows: within the map, addresses without a row read as no
value (words) or 0 (bits). Only a read that begins behind the last row, or ends behind the map, answers exception 2.
"""

import importlib.metadata
import itertools
import logging
import struct
from collections.abc import Callable, Mapping

from plc.process_image import ProcessImage, decode_set_points, encode, encode_set_points
from plc.registers import (
    BARS,
    BITS_END,
    COMMANDS,
    DISCRETES,
    INGOT_RING,
    MAP_VERSION,
    MEASUREMENTS,
    READING_RING,
    REGISTERS,
    SET_POINTS,
    WORDS_END,
)
from plc.rows import select
from plc.security.refusals import Refusals, WriteLog
from plc.security.roles import Client

OnWrite = Callable[[Mapping[str, int | bool], Client], None]

logger = logging.getLogger(__name__)

_TWO_WORDS = struct.Struct(">HH")
_COIL_LEVELS = {0x0000: False, 0xFF00: True}
_SET_POINT_ROWS = {row.name: row for row in select(REGISTERS, "holding", "rw")}
_UNUSED = b"\xff\xff"
_NO_SET_POINTS = _UNUSED * len(SET_POINTS)  # in input registers
_AREAS = (MEASUREMENTS, SET_POINTS, READING_RING, INGOT_RING, BARS, range(WORDS_END, WORDS_END))
_GAPS = [_UNUSED * (after.start - before.stop) for before, after in itertools.pairwise(_AREAS)]
_UNLOGGED = "plc_heartbeat"  # changes with every scan
_COMMAND_ROWS = select(REGISTERS, "coil", "rw")
_IDENTITY = {
    0: b"Hotgauge",  # vendor
    1: b"hotgauge",  # product code
    2: importlib.metadata.version("hotgauge").encode(),  # revision
    4: b"Hotgauge bar gauge",  # product name
    5: f"register map {MAP_VERSION}".encode(),  # model
}
_BASIC_OBJECTS = range(3)
_REGULAR_AND_INDIVIDUAL = 0x82


class _Refused(Exception):  # noqa: N818  an answer, not an error of ours
    def __init__(self, code: int) -> None:
        super().__init__(code)
        self.code = code


def _require(holds: bool, code: int) -> None:
    if not holds:
        raise _Refused(code)


def _require_within(wanted: range, area: range) -> None:
    _require(area.start <= wanted.start and wanted.stop <= area.stop, 2)


def _require_readable(wanted: range, rows_end: int, map_end: int) -> None:
    _require(wanted.start < rows_end and wanted.stop <= map_end, 2)


def _wanted(request: bytes, count_max: int) -> range:
    """Addresses that the first five bytes of a request name."""
    _require(len(request) >= 5, 3)
    start, count = _TWO_WORDS.unpack_from(request, 1)
    _require(1 <= count <= count_max, 3)
    return range(start, start + count)


def _wanted_alone(request: bytes, count_max: int) -> range:
    """Addresses that a request names which has nothing else to say."""
    _require(len(request) == 5, 3)
    return _wanted(request, count_max)


class Tables:
    """What can be read and written, and the answers to requests.

    Parameters
    ----------
    on_write : callable or None
        Called with what a write changes, by name; if it raises, nothing is written and the answer is
        exception 4.
    refusals : Refusals
        Gets writes that a client has no right to.

    Attributes
    ----------
    image : ProcessImage
        What the gauge says; every answer is made from one image.
    """

    def __init__(self, *, on_write: OnWrite | None, refusals: Refusals) -> None:
        self._on_write = on_write
        self._refusals = refusals
        self._log = WriteLog()
        self._set_points = bytes(2 * len(SET_POINTS))
        self._commands = 0
        self.image = encode({})
        self._reads: dict[int, Callable[[bytes], bytes]] = {
            1: self._read_coils,
            2: self._read_discretes,
            3: self._read_holding,
            4: self._read_input,
            43: self._identify,
        }
        self._writes: dict[int, Callable[[bytes, Client], bytes]] = {
            5: self._write_coil,
            6: self._write_register,
            15: self._write_coils,
            16: self._write_registers,
            23: self._write_and_read_registers,
        }

    def answer(self, request: bytes, client: Client) -> bytes:
        """Answer one request.

        Parameters
        ----------
        request : bytes
            Function code and what follows, at least one byte.
        client : Client
            Who asks; what it may not do answers exception 1.

        Returns
        -------
        bytes
            Function code and what follows.
        """
        function = request[0]
        try:
            if function in self._reads:
                return request[:1] + self._reads[function](request)
            _require(function in self._writes, 1)
            self._require_right(function, client)
            return request[:1] + self._writes[function](request, client)
        except _Refused as refused:
            return bytes((function | 0x80, refused.code))
        except Exception:
            logger.exception("request %s failed", request.hex())
            return bytes((function | 0x80, 4))

    def _require_right(self, function: int, client: Client) -> None:
        if function not in client.functions:
            self._refusals.tell(client.address, f"it may not write with function {function}: {client.limit}")
            raise _Refused(1)

    def restore(self, written: Mapping[str, int | bool]) -> None:
        """Take over what the PLC had written before a restart, by name; nobody is told."""
        self._set_points = encode_set_points(written, word_order=self.image.word_order)
        self._commands = sum(bool(written.get(row.name)) << place for place, row in enumerate(_COMMAND_ROWS))

    def _read_input(self, request: bytes) -> bytes:
        wanted = _wanted_alone(request, 125)
        _require_readable(wanted, BARS.stop, WORDS_END)
        return _words(self.image, _NO_SET_POINTS, wanted)

    def _read_holding(self, request: bytes) -> bytes:
        wanted = _wanted_alone(request, 125)
        _require_readable(wanted, BARS.stop, WORDS_END)
        return self._holding(wanted)

    def _holding(self, wanted: range) -> bytes:
        return _words(self.image, self._set_points, wanted)

    def _read_coils(self, request: bytes) -> bytes:
        wanted = _wanted_alone(request, 2000)
        _require_readable(wanted, COMMANDS.stop, BITS_END)
        return _bits(self.image.coils | self._commands << COMMANDS.start, wanted.start, len(wanted))

    def _read_discretes(self, request: bytes) -> bytes:
        wanted = _wanted_alone(request, 2000)
        _require_readable(wanted, DISCRETES.stop, BITS_END)
        return _bits(self.image.discretes, wanted.start, len(wanted))

    def _write_coil(self, request: bytes, client: Client) -> bytes:
        _require(len(request) == 5, 3)
        address, level = _TWO_WORDS.unpack_from(request, 1)
        _require(level in _COIL_LEVELS, 3)
        self._command(range(address, address + 1), int(_COIL_LEVELS[level]), client)
        return request[1:]

    def _write_coils(self, request: bytes, client: Client) -> bytes:
        wanted = _wanted(request, 1968)
        size = -(-len(wanted) // 8)
        _require(len(request) == 6 + size and request[5] == size, 3)
        self._command(wanted, int.from_bytes(request[6:], "little"), client)
        return request[1:5]

    def _command(self, wanted: range, levels: int, client: Client) -> None:
        _require_within(wanted, COMMANDS)
        new = self._commands
        for place, address in enumerate(wanted):
            bit = 1 << address - COMMANDS.start
            new = new | bit if levels >> place & 1 else new & ~bit
        changed = {
            row.name: bool(new >> place & 1)
            for place, row in enumerate(_COMMAND_ROWS)
            if (new ^ self._commands) >> place & 1
        }
        self._tell({name: not level for name, level in changed.items()}, changed, client)
        self._commands = new

    def _write_register(self, request: bytes, client: Client) -> bytes:
        _require(len(request) == 5, 3)
        (address,) = struct.unpack_from(">H", request, 1)
        self._set(self._checked(range(address, address + 1), request[3:]), client)
        return request[1:]

    def _write_registers(self, request: bytes, client: Client) -> bytes:
        wanted = _wanted(request, 123)
        size = 2 * len(wanted)
        _require(len(request) == 6 + size and request[5] == size, 3)
        self._set(self._checked(wanted, request[6:]), client)
        return request[1:5]

    def _write_and_read_registers(self, request: bytes, client: Client) -> bytes:
        to_read = _wanted(request, 125)
        to_write = _wanted(request[4:], 121)
        size = 2 * len(to_write)
        _require(len(request) == 10 + size and request[9] == size, 3)
        written = self._checked(to_write, request[10:])
        _require_readable(to_read, BARS.stop, WORDS_END)
        self._set(written, client)
        return self._holding(to_read)

    def _checked(self, wanted: range, words: bytes) -> bytes:
        """Set points as a write would leave them; judges values before the range."""
        new = bytearray(self._set_points)
        for place, address in enumerate(wanted):
            if address in SET_POINTS:
                first = 2 * (address - SET_POINTS.start)
                new[first : first + 2] = words[2 * place : 2 * place + 2]
        before, after = self._numbers(self._set_points), self._numbers(bytes(new))
        changed = {name: raw for name, raw in after.items() if raw != before[name]}
        _require(all(_SET_POINT_ROWS[name].accepts(raw) for name, raw in changed.items()), 3)
        _require_within(wanted, SET_POINTS)
        return bytes(new)

    def _numbers(self, words: bytes) -> dict[str, int]:
        return decode_set_points(words, word_order=self.image.word_order)

    def _set(self, words: bytes, client: Client) -> None:
        if words == self._set_points:
            return
        before, after = self._numbers(self._set_points), self._numbers(words)
        self._tell(before, {name: raw for name, raw in after.items() if raw != before[name]}, client)
        self._set_points = words

    def _tell(self, before: Mapping[str, int | bool], changed: Mapping[str, int | bool], client: Client) -> None:
        if not changed:
            return
        if self._on_write is not None:
            self._on_write(changed, client)
        logged = [
            f"{name} {_shown(name, before[name])} -> {_shown(name, raw)}"
            for name, raw in changed.items()
            if name != _UNLOGGED
        ]
        if logged:
            self._log.tell(client, ", ".join(logged))

    def _identify(self, request: bytes) -> bytes:
        _require(len(request) >= 2 and request[1] == 14, 1)
        _require(len(request) == 4 and 1 <= request[2] <= 4, 3)
        code, first = request[2:]
        if code == 4:
            _require(first in _IDENTITY, 2)
            chosen = {first: _IDENTITY[first]}
        else:
            chosen = {key: text for key, text in _IDENTITY.items() if code > 1 or key in _BASIC_OBJECTS}
            chosen = {key: text for key, text in chosen.items() if key >= first or first not in chosen}
        objects = b"".join(bytes((key, len(text))) + text for key, text in chosen.items())
        return bytes((14, code, _REGULAR_AND_INDIVIDUAL, 0, 0, len(chosen))) + objects


def _bits(table: int, start: int, count: int) -> bytes:
    size = -(-count // 8)
    return bytes((size,)) + (table >> start & (1 << count) - 1).to_bytes(size, "little")


def _words(image: ProcessImage, set_points: bytes, wanted: range) -> bytes:
    """Words of the map with their count; what has no row reads as no value."""
    table = image.words
    if wanted.stop > MEASUREMENTS.stop:
        table = b"".join(
            (
                table,
                _GAPS[0],
                set_points,
                _GAPS[1],
                image.reading_ring,
                _GAPS[2],
                image.ingot_ring,
                _GAPS[3],
                image.bars,
                _GAPS[4],
            )
        )
    return bytes((2 * len(wanted),)) + table[2 * wanted.start : 2 * wanted.stop]


def _shown(name: str, raw: int) -> str:
    """A number that was written, in its unit."""
    if name not in _SET_POINT_ROWS:
        return str(int(raw))
    row = _SET_POINT_ROWS[name]
    return f"{raw * row.scale:.{0 if row.scale == 1 else 2}f} {row.unit}".rstrip()
