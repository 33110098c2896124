"""The register map as Markdown, CSV, JSON and IEC 61131-3 structured text, each made from the one table."""

import csv
import io
import json
import math
from collections.abc import Sequence

from plc.registers import INGOT_RING, MAP_VERSION, MEASUREMENTS, READING_RING, REGISTERS
from plc.rows import Register, Table, select

_Entry = dict[str, str | int | float | None]

_COLUMNS: tuple[str, ...] = (
    "name",
    "table",
    "address",
    "words",
    "type",
    "unit",
    "scale",
    "invalid",
    "access",
    "text",
)
_IEC_TYPES = {
    "u16": "UINT",
    "i16": "INT",
    "u32": "UDINT",
    "i32": "DINT",
    "u64": "ULINT",
    "f32": "REAL",
    "bool": "BOOL",
}
_HEADINGS: dict[Table, str] = {
    "input": "Input registers (function 4)",
    "holding": "Holding registers (functions 3, 6, 16, 23)",
    "discrete": "Discrete inputs (function 2)",
    "coil": "Coils (functions 1, 5, 15)",
}


def _all_entries() -> list[_Entry]:
    return [entry for table in _HEADINGS for entry in _entries(table)]


def _entries(table: Table) -> list[_Entry]:
    rows = sorted((row for row in REGISTERS if table in row.tables), key=lambda row: row.address)
    return [_entry(row, table) for row in rows]


def _entry(row: Register, table: Table) -> _Entry:
    invalid = "NaN" if row.invalid is not None and math.isnan(row.invalid) else row.invalid
    values = (
        row.name,
        table,
        row.address,
        row.words,
        row.type,
        row.unit,
        row.scale,
        invalid,
        row.access,
        _text(row),
    )
    return dict(zip(_COLUMNS, values, strict=True))


def _text(row: Register) -> str:
    if row.lower is None or row.upper is None:
        return row.text
    return f"{row.text}; {row.lower:g} to {row.upper:g}, 0 = not set"


def to_json() -> str:
    """Register map as JSON: one row per table, so that a measurement stands twice.

    `invalid` is the number in the words that means "no value" before scaling ("NaN" for floats), null in rows
    that always have one.
    """
    registers = [entry for table in _HEADINGS for entry in _entries(table)]
    return json.dumps({"map_version": MAP_VERSION, "registers": registers}, indent=1, ensure_ascii=False) + "\n"


def to_csv() -> str:
    """Register map as comma-separated values with a heading line and the columns of the JSON form."""
    text = io.StringIO()
    writer = csv.DictWriter(text, _COLUMNS, lineterminator="\n")
    writer.writeheader()
    for entry in _all_entries():
        writer.writerow(entry)
    return text.getvalue()


def to_markdown() -> str:
    """Register map as Markdown, a table of rows for each Modbus table."""
    sections = [_markdown_section(table, heading) for table, heading in _HEADINGS.items()]
    return "\n".join(
        [
            f"# Register map, version {MAP_VERSION}\n",
            "Addresses are 0-based, as on the wire. A value is scale x number; `invalid` is the number that",
            "means no value. The most significant word comes first unless the gauge is set otherwise.",
            f"Words {_ends(MEASUREMENTS)} are one block, which one request reads whole; so are the rings of the",
            f"last readings ({_ends(READING_RING)}) and of the last ingots ({_ends(INGOT_RING)}).\n",
            *sections,
        ]
    )


def _ends(words: range) -> str:
    return f"{words[0]} to {words[-1]}"


def _markdown_section(table: Table, heading: str) -> str:
    columns = [column for column in _COLUMNS if column != "table"]
    lines = [f"## {heading}\n", _markdown_line(columns), _markdown_line(["---"] * len(columns))]
    lines += [
        _markdown_line(["" if entry[column] is None else str(entry[column]) for column in columns])
        for entry in _entries(table)
    ]
    return "\n".join(lines) + "\n"


def _markdown_line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def to_structured_text() -> str:
    """Register map as IEC 61131-3 structured text: a structure for each contiguous run of addresses.

    Every value stands at a multiple of its own length, so compilers that align structures add no padding.
    """
    runs = (
        ("HOTGAUGE_MEASUREMENT", "input and holding registers", select(REGISTERS, "input", "r", "measurement")),
        ("HOTGAUGE_READING_RING", "input and holding registers", select(REGISTERS, "input", "r", "reading_ring")),
        ("HOTGAUGE_INGOT_RING", "input and holding registers", select(REGISTERS, "input", "r", "ingot_ring")),
        ("HOTGAUGE_SET_POINTS", "holding registers", select(REGISTERS, "holding", "rw")),
        ("HOTGAUGE_ALARMS", "coils", select(REGISTERS, "coil", "r")),
        ("HOTGAUGE_COMMANDS", "coils", select(REGISTERS, "coil", "rw")),
        ("HOTGAUGE_DISCRETE_INPUTS", "discrete inputs", select(REGISTERS, "discrete", "r")),
    )
    return f"(* Hotgauge register map, version {MAP_VERSION} *)\n" + "".join(
        _structure(name, place, rows) for name, place, rows in runs
    )


def _structure(name: str, place: str, rows: Sequence[Register]) -> str:
    heading = f"(* {place} {rows[0].address} to {rows[-1].end - 1} *)"
    members = "".join(f"    {row.name} : {_IEC_TYPES[row.type]}; (* {row.address}: {_remark(row)} *)\n" for row in rows)
    return f"\nTYPE {name} : {heading}\nSTRUCT\n{members}END_STRUCT;\nEND_TYPE\n"


def _remark(row: Register) -> str:
    scale = "" if row.scale == 1 else f"{row.scale:g} "
    unit = f", {scale}{row.unit}" if row.unit else ""
    return _text(row) + unit
