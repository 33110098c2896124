"""Codes that stand in the registers, each enumeration once, with its words; the standard library only."""

import enum
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Self


class Code(enum.IntEnum):
    """Numbers of one register and the words for them."""

    _value_: int
    text: str

    def __new__(cls, value: int, text: str) -> Self:
        """Member with a number and its words."""
        member = int.__new__(cls, value)
        member._value_ = value
        member.text = text
        return member

    @classmethod
    def words(cls) -> str:
        """All numbers with their words, as they stand in the text of a register."""
        return ", ".join(f"{int(code)} {code.text}" for code in cls)

    @classmethod
    def texts(cls) -> dict[int, str]:
        """Words by number."""
        return {int(code): code.text for code in cls}


class DeviceState(Code):
    """NAMUR NE 107 classes; the larger number is the worse state."""

    GOOD = 0, "good"
    MAINTENANCE_REQUIRED = 1, "maintenance required"
    OUT_OF_SPECIFICATION = 2, "out of specification"
    FUNCTION_CHECK = 3, "test, not for control (function check)"
    FAILURE = 4, "failure"


class Validity(Code):
    """Whether values may be used."""

    NONE = 0, "none"
    VALID = 1, "valid"
    VALID_WITH_REASONS = 2, "valid with reasons"


class Decision(Code):
    """Outcome of the comparison of a size with its tolerance."""

    NONE = 0, "none"
    IN = 1, "in"
    OUT = 2, "out"
    UNDECIDED = 3, "undecided"


class Orientation(Code):
    """End of the ingot that faces the line."""

    NONE = 0, "none"
    TOP = 1, "top"
    BOTTOM = 2, "bottom"
    UNDECIDED = 3, "undecided"


class NamedBit(NamedTuple):
    """One bit of a word: its number, its name, and what it says."""

    bit: int
    name: str
    text: str


Bits = Mapping[str, Sequence[NamedBit]]
"""Named bits of words, by register."""

CODES: dict[str, type[Code]] = {
    "device_state": DeviceState,
    "validity": Validity,
    "decision": Decision,
    "ingot_orientation": Orientation,
    "ingot_validity": Validity,
}
"""Registers that hold a code."""
