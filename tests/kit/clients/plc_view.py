"""What a PLC sees of the appliance, over a connection that stays open."""

import struct
import time
from collections.abc import Callable

from modbus_wire import Wire, read, write_coils

from plc.process_image import decode, decode_discretes
from plc.registers import DISCRETES, MEASUREMENTS

Values = dict[str, float | int | None]


def look(wire: Wire) -> Values:
    """The measurement block, read in one request."""
    words = wire.ask(read(4, MEASUREMENTS.start, len(MEASUREMENTS)))[2:]
    return decode(struct.unpack(f">{len(MEASUREMENTS)}H", words))


def look_at_bits(wire: Wire) -> dict[str, bool]:
    answer = wire.ask(read(2, DISCRETES.start, len(DISCRETES)))[2:]
    return decode_discretes([bool(answer[bit // 8] >> bit % 8 & 1) for bit in range(len(DISCRETES))])


def acknowledge(wire: Wire) -> None:
    """Acknowledge all alarms: coil 32 to 1 and back to 0."""
    assert wire.ask(write_coils(32, True))[0] == 15
    assert wire.ask(write_coils(32, False))[0] == 15


def wait_for(wire: Wire, wanted: Callable[[Values], bool], within_s: float) -> Values:
    """First block that is as wanted, polled every 20 ms; fails when none is in time."""
    until = time.monotonic() + within_s
    while time.monotonic() < until:
        seen = look(wire)
        if wanted(seen):
            return seen
        time.sleep(0.02)
    raise AssertionError(f"not seen within {within_s} s; last: {seen}")


def has_value(seen: Values) -> bool:
    return seen["validity"] != 0


def has_none(seen: Values) -> bool:
    return seen["validity"] == 0
