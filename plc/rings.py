"""Rows of the rings: blocks that hold the last readings and the last ingots, so that a slow PLC loses none."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from plc.codes import Orientation, Validity
from plc.rows import NO_VALUE, Block, Register, Type, spare


class Field(NamedTuple):
    """One value of every slot of a ring; `optional` if it may be no value, `shows` if it repeats another field."""

    name: str
    type: Type
    text: str
    unit: str = ""
    scale: float = 1
    optional: bool = True
    shows: str = ""


SLOTS = 8
_SLOT_WORDS = 12
READING_SLOT = (
    Field("timestamp", "u64", "moment of exposure, since 1970-01-01 00:00 UTC", "ms"),
    Field("diameter", "f32", "diameter of the bar, hot", "mm"),
    Field("expanded_uncertainty", "f32", "expanded uncertainty (k = 2) of the diameter", "mm"),
    Field("diameter_u16", "u16", "diameter as an integer", "mm", 0.01, shows="diameter"),
    Field("trust", "u16", "how far the diameter can be trusted, 0 to 100", "%", 0.01),
    Field("sequence", "u16", "the word sequence when this was the newest reading", optional=False),
    Field("validity", "u16", Validity.words(), optional=False),
)
INGOT_SLOT = (
    Field("timestamp", "u64", "moment of the decision, since 1970-01-01 00:00 UTC", "ms"),
    Field("ssim_top", "f32", "similarity of the end to the top reference, -1 to 1"),
    Field("ssim_bottom", "f32", "similarity of the end to the bottom reference, -1 to 1"),
    Field("confidence", "u16", "confidence of the orientation, 0 to 100", "%", 0.01),
    Field("sequence", "u16", "the word ingot_sequence of this ingot", optional=False),
    Field("validity", "u16", Validity.words(), optional=False),
    Field("orientation", "u16", f"end facing the line: {Orientation.words()}", optional=False),
)
READING_FIELDS = tuple(field.name for field in READING_SLOT if not field.shows)


def ring(address: int, block: Block, what: str, slot: Sequence[Field]) -> Iterator[Register]:
    """Index, three spare words (so that each slot begins at a multiple of the longest value), slots."""
    text = f"{what}s written since the start; the newest stands in slot (index - 1) modulo {SLOTS}"
    yield Register(
        name=f"{block}_index", tables=("input", "holding"), address=address, type="u16", text=text, block=block
    )
    yield from (spare(address + place, block) for place in (1, 2, 3))
    for number in range(SLOTS):
        place = address + 4 + number * _SLOT_WORDS
        for field in slot:
            row = in_slot(place, block, f"{what}_{number}", field)
            yield row
            place = row.end


def in_slot(address: int, block: Block, slot: str, field: Field) -> Register:
    """Row of one value of a slot.

    Parameters
    ----------
    address : int
    block : str
        Of `Block`.
    slot : str
        Name of the slot; the row's begins with it.
    field : Field
    """
    return Register(
        name=f"{slot}_{field.name}",
        tables=("input", "holding"),
        address=address,
        type=field.type,
        unit=field.unit,
        scale=field.scale,
        invalid=NO_VALUE[field.type] if field.optional else None,
        shows=f"{slot}_{field.shows}" if field.shows else "",
        text=field.text,
        block=block,
    )
