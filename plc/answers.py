"""Answers to Modbus requests, from a process image and from what the PLC has written.

Rules after the Modbus Application Protocol V1.1b3. A request is checked in this order, and nothing is written
before all checks have passed: function (exception 1), quantity and values (3), range (2), act (4).
"""

import importlib.metadata
import logging
import struct
from collections.abc import Callable, Mapping

from plc.process_image import decode_set_points, encode, encode_set_points
from plc.registers import (
    ALARMS,
    COMMANDS,
    DISCRETES,
    INGOT_RING,
    MAP_VERSION,
    MEASUREMENTS,
    READING_RING,
    REGISTERS,
    SET_POINTS,
)
from plc.rows import select

OnWrite = Callable[[Mapping[str, int | bool]], None]

logger = logging.getLogger(__name__)

_TWO_WORDS = struct.Struct(">HH")
_COIL_LEVELS = {0x0000: False, 0xFF00: True}
_SET_POINT_ROWS = {row.name: row for row in select(REGISTERS, "holding", "rw")}
_INPUT_AREAS = (MEASUREMENTS, READING_RING, INGOT_RING)
_HOLDING_AREAS = (*_INPUT_AREAS, SET_POINTS)
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


def _within(wanted: range, *areas: range) -> bool:
    return any(area.start <= wanted.start and wanted.stop <= area.stop for area in areas)


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
    writable : bool
        Whether set points and commands may be written.
    on_write : callable or None
        Called with what a write changes, by name; if it raises, nothing is written and the answer is
        exception 4.

    Attributes
    ----------
    image : ProcessImage
        What the gauge says; every answer is made from one image.
    """

    def __init__(self, *, writable: bool, on_write: OnWrite | None) -> None:
        self.image = encode({})
        self._set_points = bytes(2 * len(SET_POINTS))
        self._commands = 0
        self._on_write = on_write
        self._functions: dict[int, Callable[[bytes], bytes]] = {
            1: self._read_coils,
            2: self._read_discretes,
            3: self._read_holding,
            4: self._read_input,
            43: self._identify,
        }
        if writable:
            self._functions |= {
                5: self._write_coil,
                6: self._write_register,
                15: self._write_coils,
                16: self._write_registers,
                23: self._write_and_read_registers,
            }

    def answer(self, request: bytes) -> bytes:
        """Answer one request (function code and what follows, at least one byte)."""
        function = request[0]
        try:
            _require(function in self._functions, 1)
            return request[:1] + self._functions[function](request)
        except _Refused as refused:
            return bytes((function | 0x80, refused.code))
        except Exception:
            logger.exception("request %s failed", request.hex())
            return bytes((function | 0x80, 4))

    def restore(self, written: Mapping[str, int | bool]) -> None:
        """Take over what the PLC had written before a restart, by name; nobody is told."""
        self._set_points = encode_set_points(written, word_order=self.image.word_order)
        self._commands = sum(bool(written.get(row.name)) << place for place, row in enumerate(_COMMAND_ROWS))

    def _read_input(self, request: bytes) -> bytes:
        wanted = _wanted_alone(request, 125)
        _require(_within(wanted, *_INPUT_AREAS), 2)
        return self._words(wanted)

    def _read_holding(self, request: bytes) -> bytes:
        wanted = _wanted_alone(request, 125)
        _require(_within(wanted, *_HOLDING_AREAS), 2)
        return self._words(wanted)

    def _words(self, wanted: range) -> bytes:
        image = self.image
        contents = (image.words, image.reading_ring, image.ingot_ring, self._set_points)
        area, words = next(
            (area, words) for area, words in zip(_HOLDING_AREAS, contents, strict=True) if wanted.start in area
        )
        first, size = 2 * (wanted.start - area.start), 2 * len(wanted)
        return bytes((size,)) + words[first : first + size]

    def _read_coils(self, request: bytes) -> bytes:
        wanted = _wanted_alone(request, 2000)
        if _within(wanted, ALARMS):
            return _bits(self.image.coils, wanted.start, len(wanted))
        _require(_within(wanted, COMMANDS), 2)
        return _bits(self._commands, wanted.start - COMMANDS.start, len(wanted))

    def _read_discretes(self, request: bytes) -> bytes:
        wanted = _wanted_alone(request, 2000)
        _require(_within(wanted, DISCRETES), 2)
        return _bits(self.image.discretes, wanted.start, len(wanted))

    def _write_coil(self, request: bytes) -> bytes:
        _require(len(request) == 5, 3)
        address, level = _TWO_WORDS.unpack_from(request, 1)
        _require(level in _COIL_LEVELS, 3)
        self._command(range(address, address + 1), int(_COIL_LEVELS[level]))
        return request[1:]

    def _write_coils(self, request: bytes) -> bytes:
        wanted = _wanted(request, 1968)
        size = -(-len(wanted) // 8)
        _require(len(request) == 6 + size and request[5] == size, 3)
        self._command(wanted, int.from_bytes(request[6:], "little"))
        return request[1:5]

    def _command(self, wanted: range, levels: int) -> None:
        _require(_within(wanted, COMMANDS), 2)
        new = self._commands
        for place, address in enumerate(wanted):
            bit = 1 << address - COMMANDS.start
            new = new | bit if levels >> place & 1 else new & ~bit
        changed = {
            row.name: bool(new >> place & 1)
            for place, row in enumerate(_COMMAND_ROWS)
            if (new ^ self._commands) >> place & 1
        }
        self._tell(changed)
        self._commands = new

    def _write_register(self, request: bytes) -> bytes:
        _require(len(request) == 5, 3)
        (address,) = struct.unpack_from(">H", request, 1)
        self._set(*self._checked(range(address, address + 1), request[3:]))
        return request[1:]

    def _write_registers(self, request: bytes) -> bytes:
        wanted = _wanted(request, 123)
        size = 2 * len(wanted)
        _require(len(request) == 6 + size and request[5] == size, 3)
        self._set(*self._checked(wanted, request[6:]))
        return request[1:5]

    def _write_and_read_registers(self, request: bytes) -> bytes:
        to_read = _wanted(request, 125)
        to_write = _wanted(request[4:], 121)
        size = 2 * len(to_write)
        _require(len(request) == 10 + size and request[9] == size, 3)
        written = self._checked(to_write, request[10:])
        _require(_within(to_read, *_HOLDING_AREAS), 2)
        self._set(*written)
        return self._words(to_read)

    def _checked(self, wanted: range, words: bytes) -> tuple[bytes, dict[str, int]]:
        """Set points as a write would leave them, and what it changes; judges values before the range."""
        new = bytearray(self._set_points)
        for place, address in enumerate(wanted):
            if address in SET_POINTS:
                first = 2 * (address - SET_POINTS.start)
                new[first : first + 2] = words[2 * place : 2 * place + 2]
        order = self.image.word_order
        before = decode_set_points(self._set_points, word_order=order)
        after = decode_set_points(bytes(new), word_order=order)
        changed = {name: raw for name, raw in after.items() if raw != before[name]}
        _require(all(_SET_POINT_ROWS[name].accepts(raw) for name, raw in changed.items()), 3)
        _require(_within(wanted, SET_POINTS), 2)
        return bytes(new), changed

    def _set(self, words: bytes, changed: dict[str, int]) -> None:
        self._tell(changed)
        self._set_points = words

    def _tell(self, changed: Mapping[str, int | bool]) -> None:
        if changed and self._on_write is not None:
            self._on_write(changed)

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
