"""The whole text for one kind of PLC."""

from plc.codes import Bits
from plc.export import own_bits
from plc.registers import MAP_VERSION
from plc.structured_text.dialect import INDENT, Dialect, write_part
from plc.structured_text.function_block import BLOCK, REAL_OF_WORDS
from plc.structured_text.rockwell import to_rockwell
from plc.structured_text.types import constants, structures

_NO_BITS: Bits = {}


def to_structured_text(bits: Bits = _NO_BITS, *, dialect: Dialect = "codesys") -> str:
    """Register map as structured text (IEC 61131-3): structures, constants, and a function block that reads a gauge.

    Parameters
    ----------
    bits : mapping of str to sequence of NamedBit
        By register, those that are not the map's own.
    dialect : {"codesys", "tia", "rockwell"}
        `codesys` also suits TwinCAT and other compilers of IEC 61131-3; `tia` is an external source of TIA Portal for
        S7-1200 and S7-1500; `rockwell` is the logic of an add-on instruction of Studio 5000 and its tags.

    Raises
    ------
    ValueError
        `dialect` is none of these.
    """
    known = {**bits, **own_bits()}
    heading = f"Hotgauge register map, version {MAP_VERSION}"
    if dialect == "rockwell":
        return to_rockwell(heading, known)
    if dialect not in {"codesys", "tia"}:
        raise ValueError(f'dialect: {dialect!r} is not "codesys", "tia" or "rockwell"')
    parts = [*structures(dialect), *_constants(known, dialect)]
    parts += [write_part(REAL_OF_WORDS, dialect), write_part(BLOCK, dialect)]
    return "\n".join([f"(* {heading} *)" if dialect == "codesys" else f"// {heading}", "", *parts])


def _constants(bits: Bits, dialect: Dialect) -> list[str]:
    """Named constants; an external source of TIA Portal cannot hold any outside of a block, so a data block does."""
    rows = constants(bits)
    if dialect == "tia":
        lines = [f"{INDENT}{name} : Int := {number}; // {text}" for name, number, text in rows]
        return [
            "\n".join(
                [
                    'DATA_BLOCK "HOTGAUGE_CONSTANTS"',
                    "VERSION : 0.1",
                    "VAR",
                    *lines,
                    "END_VAR",
                    "BEGIN",
                    "END_DATA_BLOCK",
                    "",
                ]
            )
        ]
    lines = [f"{INDENT}{name} : INT := {number}; (* {text} *)" for name, number, text in rows]
    return ["\n".join(["VAR_GLOBAL CONSTANT", *lines, "END_VAR", ""])]
