"""The process image of one moment: values to words, and words that a client has read to values.

Examples
--------
A diameter in millimetres and back; a value that was not given is "no value", None:

>>> import struct
>>> image = encode({"diameter": 101.25, "validity": 1})
>>> words = struct.unpack(f">{len(image.words) // 2}H", image.words)
>>> values = decode(words)
>>> values["diameter"], values["validity"], values["deviation"]
(101.25, 1, None)
"""

import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plc.layout import Layout
from plc.registers import ALARMS, BLOCKS, DISCRETES, REGISTERS
from plc.rows import Block, Value, WordOrder, select

_LAYOUTS = {block: Layout(select(REGISTERS, "input", "r", block)) for block in BLOCKS}
_SET_POINT_LAYOUT = Layout(select(REGISTERS, "holding", "rw"))
_DISCRETE_ROWS = select(REGISTERS, "discrete", "r")

_SOURCES = {block: [(row, row.shows or row.name) for row in layout.rows] for block, layout in _LAYOUTS.items()}
_CONSTANTS = {row.name: row.constant for row in _LAYOUTS["measurement"].rows if row.constant is not None}
_STATUS_NAMES = [row.name for row in _DISCRETE_ROWS if row.tables == ("discrete",)]
_DERIVED = {*_CONSTANTS, "status_word"}
_ROWS = {row.name: row for row in REGISTERS}
VALUE_NAMES = frozenset({source for rows in _SOURCES.values() for _, source in rows} - _DERIVED | {*_STATUS_NAMES})


@dataclass(frozen=True, slots=True)
class ProcessImage:
    """All that the gauge says at one moment; it is published whole, by one swap of a reference.

    Attributes
    ----------
    words, reading_ring, ingot_ring, bars : bytes
        The measurement block, the two rings and the bars side by side, two bytes a word, most significant byte first.
    coils, discretes : int
        Alarm coils and discrete inputs; bit n is address n.
    word_order : {"big", "little"}
        Order of the words in values of more than one word, in the blocks and in set points.
    """

    words: bytes
    reading_ring: bytes
    ingot_ring: bytes
    bars: bytes
    coils: int
    discretes: int
    word_order: WordOrder


def encode(values: Mapping[str, Value], *, word_order: WordOrder = "big") -> ProcessImage:
    """Make the process image of one moment.

    What repeats another value (`sequence_check`, `status_word`, alarm bits, scaled integers) and constants
    are filled in here. A value that is missing, None, NaN or too large for its row becomes the row's "no
    value", or 0 in rows that have none; counters wrap. Scaled values are rounded half to even.

    Parameters
    ----------
    values : mapping of str to float, int, bool or None
        By name, in the unit of the map; the names allowed are `VALUE_NAMES`.
    word_order : {"big", "little"}
        "big" puts the most significant word first.

    Returns
    -------
    ProcessImage

    Raises
    ------
    ValueError
        A name in `values` is unknown or is filled in here; `word_order` is neither of the two.
    TypeError
        A value is not a number.
    """
    if not values.keys() <= VALUE_NAMES:
        wrong = ", ".join(sorted(values.keys() - VALUE_NAMES))
        raise ValueError(f"values: {wrong}: not a value of the register map, or derived from another value")
    try:
        status = sum(_bit(values.get(name)) << place for place, name in enumerate(_STATUS_NAMES))
        given = {**_CONSTANTS, **values, "status_word": status}
        words, reading_ring, ingot_ring, bars = (
            layout.pack([row.to_raw(given.get(source)) for row, source in _SOURCES[block]], word_order)
            for block, layout in _LAYOUTS.items()
        )
    except TypeError as error:
        raise TypeError(f"values: every one must be a number or None ({error})") from error
    alarms = int(_ROWS["alarm_word"].to_raw(values.get("alarm_word")))
    return ProcessImage(
        words=words,
        reading_ring=reading_ring,
        ingot_ring=ingot_ring,
        bars=bars,
        coils=alarms,
        discretes=alarms | status << len(ALARMS),
        word_order=word_order,
    )


def _bit(value: Value) -> int:
    return int(value is not None and not math.isnan(value) and value != 0)


def decode(
    words: Sequence[int], *, block: Block = "measurement", word_order: WordOrder = "big"
) -> dict[str, float | int | None]:
    """Values of a block that a client has read.

    Parameters
    ----------
    words : sequence of int
        The whole block, from its first address.
    block : {"measurement", "reading_ring", "ingot_ring", "bars"}
    word_order : {"big", "little"}
        As set in the gauge.

    Returns
    -------
    dict of str to float, int or None
        Every row of the block but the spare ones, in the unit of the map; None for no value.

    Raises
    ------
    ValueError
        `words` is not the whole block; `word_order` is neither of the two.
    """
    layout = _LAYOUTS[block]
    if len(words) != len(layout.span):
        raise ValueError(f"words: {len(words)} given, the {block} block has {len(layout.span)}")
    numbers = layout.unpack(struct.pack(f">{len(words)}H", *words), word_order)
    return {row.name: row.to_value(numbers[row.name]) for row in layout.rows}


def decode_discretes(bits: Sequence[bool]) -> dict[str, bool]:
    """Names and states of the discrete inputs that a client has read from address 0.

    Parameters
    ----------
    bits : sequence of bool, length at least `len(DISCRETES)`
        Padding to whole bytes, as client libraries leave it, is ignored.

    Returns
    -------
    dict of str to bool

    Raises
    ------
    ValueError
        `bits` is too short.
    """
    if len(bits) < len(DISCRETES):
        raise ValueError(f"bits: {len(bits)} given, there are {len(DISCRETES)} discrete inputs")
    return {row.name: bits[row.address] for row in _DISCRETE_ROWS if not row.spare}


def decode_set_points(words: bytes, *, word_order: WordOrder = "big") -> dict[str, int]:
    """Numbers in the words of the set points, not scaled.

    Parameters
    ----------
    words : bytes, length 2 x `len(SET_POINTS)`
        Most significant byte of each word first.
    word_order : {"big", "little"}
        Order of the words in `product_id`.

    Returns
    -------
    dict of str to int
    """
    return {name: int(number) for name, number in _SET_POINT_LAYOUT.unpack(words, word_order).items()}


def encode_set_points(numbers: Mapping[str, int], *, word_order: WordOrder = "big") -> bytes:
    """Words of the set points.

    Parameters
    ----------
    numbers : mapping of str to int
        Numbers in the words, not scaled; a set point that is missing is 0, not set.
    word_order : {"big", "little"}
        Order of the words in `product_id`.

    Returns
    -------
    bytes, length 2 x `len(SET_POINTS)`
    """
    return _SET_POINT_LAYOUT.pack([numbers.get(row.name, 0) for row in _SET_POINT_LAYOUT.rows], word_order)
