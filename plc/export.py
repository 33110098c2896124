"""The register map as Markdown, CSV and JSON, made from the one table; `plc.structured_text` makes programs."""

import csv
import io
import json
import math
from collections.abc import Sequence

from plc.codes import CODES, Bits, NamedBit
from plc.registers import BARS, INGOT_RING, MAP_VERSION, MEASUREMENTS, READING_RING, REGISTERS
from plc.rows import Register, Table, select

_NO_BITS: Bits = {}
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
_HEADINGS: dict[Table, str] = {
    "input": "Input registers",
    "holding": "Holding registers",
    "discrete": "Discrete inputs",
    "coil": "Coils",
}
_MODICON: dict[Table, int] = {"input": 30001, "holding": 40001, "discrete": 10001, "coil": 1}
_READ_BY: dict[Table, int] = {"input": 4, "holding": 3, "discrete": 2, "coil": 1}
_WRITTEN_BY: dict[Table, tuple[int, ...]] = {"holding": (6, 16, 23), "coil": (5, 15)}
_CSV_COLUMNS: tuple[str, ...] = (
    *_COLUMNS,
    "address_1_based",
    "modicon",
    "functions",
    "lower",
    "upper",
    "bits",
    "codes",
)
_BYTE_ORDER_MARK = "\ufeff"


def _all_entries() -> list[_Entry]:
    return [entry for table in _HEADINGS for entry in _entries(table)]


def _rows(table: Table) -> list[Register]:
    return sorted((row for row in REGISTERS if table in row.tables), key=lambda row: row.address)


def _entries(table: Table) -> list[_Entry]:
    return [_entry(row, table) for row in _rows(table)]


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


def own_bits() -> Bits:
    """Bits of the words that repeat alarms and states."""
    alarms = select(REGISTERS, "coil", "r")
    states = [row for row in select(REGISTERS, "discrete", "r") if row.tables == ("discrete",)]
    return {
        "alarm_word": [NamedBit(row.address, row.name, row.text) for row in alarms if not row.spare],
        "status_word": [NamedBit(bit, row.name, row.text) for bit, row in enumerate(states)],
    }


def to_json(bits: Bits = _NO_BITS) -> str:
    """Register map as JSON: one row per table, so that a measurement stands twice.

    `invalid` is the number in the words that means "no value" before scaling ("NaN" for floats), null in rows
    that always have one. `bits` and `codes` name what single bits and numbers of a register say.

    Parameters
    ----------
    bits : mapping of str to sequence of NamedBit
        By register, those that are not the map's own.
    """
    document = {
        "map_version": MAP_VERSION,
        "registers": _all_entries(),
        "bits": [
            {"register": register, **named._asdict()}
            for register, row in ({**bits, **own_bits()}).items()
            for named in row
        ],
        "codes": [
            {"register": register, "value": value, "text": text}
            for register, code in CODES.items()
            for value, text in code.texts().items()
        ],
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def to_csv(bits: Bits = _NO_BITS, *, byte_order_mark: bool = False) -> str:
    """Register map as comma-separated values with a heading line: the columns of the JSON form, and what tools need.

    Parameters
    ----------
    bits : mapping of str to sequence of NamedBit
        By register, those that are not the map's own.
    byte_order_mark : bool
        Whether it begins with the mark by which Excel knows UTF-8.
    """
    text = io.StringIO()
    writer = csv.DictWriter(text, _CSV_COLUMNS, lineterminator="\n")
    writer.writeheader()
    known = {**bits, **own_bits()}
    for table in _HEADINGS:
        writer.writerows(_csv_entry(row, table, known) for row in _rows(table))
    return _BYTE_ORDER_MARK * byte_order_mark + text.getvalue()


def _csv_entry(row: Register, table: Table, bits: Bits) -> _Entry:
    functions = (_READ_BY[table], *(_WRITTEN_BY.get(table, ()) if row.access == "rw" else ()))
    codes = CODES[row.name].texts() if row.name in CODES else {}
    return _entry(row, table) | {
        "address_1_based": row.address + 1,
        "modicon": modicon(row, table),
        "functions": " ".join(map(str, functions)),
        "lower": row.lower,
        "upper": row.upper,
        "bits": "; ".join(f"{named.bit} {named.name}" for named in bits.get(row.name, ())),
        "codes": "; ".join(f"{value} {text}" for value, text in codes.items()),
    }


def modicon(row: Register, table: Table) -> str:
    """Address as PLCs of the Modicon kind count it, 1-based, the table in front.

    Parameters
    ----------
    row : Register
    table : {"input", "holding", "discrete", "coil"}
    """
    return f"{_MODICON[table] + row.address:05d}"


def _functions(table: Table) -> str:
    written = _WRITTEN_BY.get(table, ())
    return f"read with function {_READ_BY[table]}" + (
        f", written with {', '.join(map(str, written))}" if written else ""
    )


def to_markdown(bits: Bits = _NO_BITS) -> str:
    """Register map as Markdown, a table of rows for each Modbus table, and the names of bits.

    Parameters
    ----------
    bits : mapping of str to sequence of NamedBit
        By register, those that are not the map's own.
    """
    sections = [_markdown_section(table, f"{heading}: {_functions(table)}") for table, heading in _HEADINGS.items()]
    words = [_markdown_bits(register, named) for register, named in ({**bits, **own_bits()}).items()]
    return "\n".join(
        [
            f"# Register map, version {MAP_VERSION}\n",
            "Addresses are 0-based, as on the wire; in brackets as PLCs of the Modicon kind count them: from 1, the",
            "table in front. A value is scale x number; `invalid` is the number that means no value. The most",
            "significant word comes first unless the gauge is set otherwise.",
            f"Words {_ends(MEASUREMENTS)} are one block, which one request reads whole; so are the rings of the",
            f"last readings ({_ends(READING_RING)}) and of the last ingots ({_ends(INGOT_RING)}), and",
            f"bars side by side ({_ends(BARS)}).\n",
            *sections,
            *words,
        ]
    )


def _ends(words: range) -> str:
    return f"{words[0]} to {words[-1]}"


def _markdown_section(table: Table, heading: str) -> str:
    columns = [column for column in _COLUMNS if column != "table"]
    lines = [f"## {heading}\n", _markdown_line(columns), _markdown_line(["---"] * len(columns))]
    lines += [
        _markdown_line([_cell(column, entry[column], row, table) for column in columns])
        for row, entry in zip(_rows(table), _entries(table), strict=True)
    ]
    return "\n".join(lines) + "\n"


def _cell(column: str, content: object, row: Register, table: Table) -> str:
    if column == "address":
        return f"{content} ({modicon(row, table)})"
    return "" if content is None else str(content)


def _markdown_bits(register: str, bits: Sequence[NamedBit]) -> str:
    lines = [f"- {named.bit} `{named.name}`: {named.text}" for named in bits]
    return "\n".join([f"## Bits of `{register}`\n", *lines, ""])


def _markdown_line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
