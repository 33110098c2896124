"""Structures of the blocks, and named constants of bits and codes."""

from collections.abc import Iterator, Sequence

from plc.codes import CODES, Bits
from plc.registers import REGISTERS
from plc.rings import INGOT_SLOT, READING_SLOT, SLOTS, Field
from plc.rows import Register, Type, select
from plc.structured_text.dialect import INDENT, Dialect

IEC_TYPES: dict[Type, str] = {
    "u16": "UINT",
    "i16": "INT",
    "u32": "UDINT",
    "i32": "DINT",
    "u64": "ULINT",
    "f32": "REAL",
    "bool": "BOOL",
}


def structures(dialect: Dialect) -> Iterator[str]:
    """A structure for each run of addresses, and for the slots of rings.

    Every value stands at a multiple of its own length, so that compilers that align structures add no padding.

    Parameters
    ----------
    dialect : {"codesys", "tia"}

    Yields
    ------
    str
    """
    readings = ("HOTGAUGE_READING", READING_SLOT, "reading_ring")
    ingots = ("HOTGAUGE_INGOT", INGOT_SLOT, "ingot_ring")
    words = "input and holding registers"
    yield _structure(dialect, "HOTGAUGE_MEASUREMENT", words, select(REGISTERS, "input", "r", "measurement"))
    for name, slot, block in (readings, ingots):
        yield _written(dialect, name, f"one slot of the {block}", [_member(field) for field in slot])
        yield _written(
            dialect, f"{name}_RING", _place(words, select(REGISTERS, "input", "r", block)), _ring(name, block)
        )
    yield _structure(dialect, "HOTGAUGE_BARS", words, select(REGISTERS, "input", "r", "bars"))
    yield _structure(dialect, "HOTGAUGE_SET_POINTS", "holding registers", select(REGISTERS, "holding", "rw"))
    yield _structure(dialect, "HOTGAUGE_ALARMS", "coils", select(REGISTERS, "coil", "r"))
    yield _structure(dialect, "HOTGAUGE_COMMANDS", "coils", select(REGISTERS, "coil", "rw"))
    yield _structure(dialect, "HOTGAUGE_DISCRETE_INPUTS", "discrete inputs", select(REGISTERS, "discrete", "r"))


def _place(table: str, rows: Sequence[Register]) -> str:
    return f"{table} {rows[0].address} to {rows[-1].end - 1}"


def _structure(dialect: Dialect, name: str, table: str, rows: Sequence[Register]) -> str:
    members = [(row.name, IEC_TYPES[row.type], f"{row.address}: {_remark(row)}") for row in rows]
    return _written(dialect, name, _place(table, rows), members)


_Member = tuple[str, str, str]


def _ring(name: str, block: str) -> list[_Member]:
    return [
        (f"{block}_index", "UINT", f"written since the start; the newest is in slots[(index - 1) MOD {SLOTS}]"),
        ("spare", "ARRAY[1..3] OF UINT", ""),
        ("slots", f"ARRAY[0..{SLOTS - 1}] OF {name}", ""),
    ]


def _member(field: Field) -> _Member:
    scale = "" if field.scale == 1 else f", {field.scale:g} {field.unit}"
    return field.name, IEC_TYPES[field.type], field.text + scale


def _written(dialect: Dialect, name: str, place: str, members: Sequence[_Member]) -> str:
    lines = [f"{INDENT}{member} : {type_};" + (f" (* {text} *)" if text else "") for member, type_, text in members]
    if dialect == "tia":
        lines = [line.replace("OF HOTGAUGE_READING", 'OF "HOTGAUGE_READING"') for line in lines]
        lines = [line.replace("OF HOTGAUGE_INGOT", 'OF "HOTGAUGE_INGOT"') for line in lines]
        head, end = [f"// {place}", f'TYPE "{name}"', "VERSION : 0.1", "STRUCT"], ["END_STRUCT;", "END_TYPE", ""]
    else:
        head, end = [f"TYPE {name} : (* {place} *)", "STRUCT"], ["END_STRUCT", "END_TYPE", ""]
    return "\n".join([*head, *lines, *end])


def _remark(row: Register) -> str:
    scale = "" if row.scale == 1 else f"{row.scale:g} "
    bounds = "" if row.lower is None or row.upper is None else f"; {row.lower:g} to {row.upper:g}, 0 = not set"
    return row.text + bounds + (f", {scale}{row.unit}" if row.unit else "")


def constants(bits: Bits) -> list[tuple[str, int, str]]:
    """Names of bits and codes, their numbers, and what they say.

    Parameters
    ----------
    bits : mapping of str to sequence of NamedBit
        By register.
    """
    named = [
        (f"HOTGAUGE_{_short(register)}_{one.name}", int(one), f"{register}: {one.text}")
        for register, code in CODES.items()
        if register != "ingot_validity"
        for one in code
    ]
    return named + [
        (f"HOTGAUGE_{_short(register)}_BIT_{_constant(one.name.removeprefix('alarm_'))}", one.bit, one.text)
        for register, row in bits.items()
        for one in row
    ]


def _short(register: str) -> str:
    return register.removesuffix("_word").upper()


def _constant(text: str) -> str:
    return text.upper().replace(" ", "_")
