"""Rows of the block of bars that pass side by side: a slot for each, which it keeps while it passes."""

from collections.abc import Iterator

from plc.codes import Validity
from plc.rings import Field, in_slot
from plc.rows import Register, spare

BAR_SLOTS = 4
_SLOT_WORDS = 20
_FIRST_SLOT = 4  # words before it: their number, and spare ones, so that slots begin at a multiple of four words
BAR_SLOT = (
    Field("diameter", "f32", "diameter of this bar, hot", "mm"),
    Field("expanded_uncertainty", "f32", "expanded uncertainty (k = 2) of the diameter", "mm"),
    Field("mean_diameter", "f32", "its diameter from its last frames, hot", "mm"),
    Field("mean_expanded_uncertainty", "f32", "expanded uncertainty (k = 2) of mean_diameter", "mm"),
    Field("offset", "f32", "place of its axis across the line, x at y = 0", "mm"),
    Field("diameter_u16", "u16", "diameter as an integer", "mm", 0.01, shows="diameter"),
    Field("validity", "u16", Validity.words(), optional=False),
    Field("reason_word", "u32", "reason flags of this bar, one bit each", optional=False),
)
BAR_FIELDS = tuple(field.name for field in BAR_SLOT if not field.shows)


def bars(address: int) -> Iterator[Register]:
    """Number of bars, spare words, a slot for each bar."""
    yield Register(
        name="bars_count",
        tables=("input", "holding"),
        address=address,
        type="u16",
        text="bars side by side in the newest pair; 0 where there is one or none, which the measurement block holds",
        block="bars",
    )
    yield from (spare(address + place, "bars") for place in range(1, _FIRST_SLOT))
    for number in range(BAR_SLOTS):
        place = address + _FIRST_SLOT + number * _SLOT_WORDS
        end = place + _SLOT_WORDS
        for field in BAR_SLOT:
            row = in_slot(place, "bars", f"bar_{number + 1}", field)
            yield row
            place = row.end
        yield from (spare(word, "bars") for word in range(place, end))
