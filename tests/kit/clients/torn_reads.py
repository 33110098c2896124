"""Counts blocks whose words do not all belong to one process image."""

import struct
import time
from collections.abc import Callable
from typing import NamedTuple

from modbus_wire import Wire, read

from plc.process_image import decode
from plc.registers import MEASUREMENTS, REGISTERS
from plc.rows import WordOrder


class Blocks(NamedTuple):
    read: int
    torn: int


def count_torn(port: int, seconds: float, of_one_image: Callable[[bytes], bool]) -> Blocks:
    """Read the whole block as fast as one client can and judge every answer by `of_one_image`."""
    until = time.monotonic() + seconds
    request = read(4, MEASUREMENTS.start, len(MEASUREMENTS))
    count = torn = 0
    with Wire(port) as wire:
        while time.monotonic() < until:
            words = wire.ask(request)[2:]
            count += 1
            torn += not of_one_image(words)
    return Blocks(count, torn)


def agrees_with_itself(words: bytes, *, word_order: WordOrder = "big") -> bool:
    """Whether a block contradicts itself nowhere: sequence, and each value against its scaled integer."""
    values = decode(struct.unpack(f">{len(MEASUREMENTS)}H", words), word_order=word_order)
    if values["sequence"] != values["sequence_check"]:
        return False
    return all(
        _equal(values[row.shows], values[row.name], row.scale)
        for row in REGISTERS
        if row.shows in values and "input" in row.tables
    )


def _equal(value: float | None, scaled: float | None, scale: float) -> bool:
    if value is None or scaled is None:
        return value is scaled
    return abs(value - scaled) <= 0.51 * scale
