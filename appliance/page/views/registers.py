"""The view of the registers: every row of the map with its words and its value, and the documents for download."""

from collections.abc import Callable, Mapping
from typing import Any, get_args

from appliance.diagnostics.named_bits import named_bits
from appliance.page.access.logins import Login
from appliance.page.parts import Parts
from appliance.page.texts import Texts
from plc import export
from plc.poll import Snapshot, value_in_words
from plc.registers import BARS, MEASUREMENTS, REGISTERS, SET_POINTS
from plc.rows import Register, Table, select
from plc.structured_text.dialect import Dialect
from plc.structured_text.program import to_structured_text

_BITS = named_bits()
_ALL_BITS = {**_BITS, **export.own_bits()}

DOCUMENTS: Mapping[str, Callable[[], str]] = {
    "registers.md": lambda: export.to_markdown(_BITS),
    "registers.csv": lambda: export.to_csv(_BITS, byte_order_mark=True),
    "registers.json": lambda: export.to_json(_BITS),
    **{f"registers-{name}.st": lambda name=name: to_structured_text(_BITS, dialect=name) for name in get_args(Dialect)},
}
"""Documents of the register map by file name, as `hotgauge registers` writes them."""


def values(parts: Parts, texts: Texts, _login: Login) -> dict[str, Any]:
    """What the view shows now.

    Parameters
    ----------
    parts : Parts
    texts : Texts
    """
    snapshot = parts.watch.newest
    tables: list[dict[str, Any]] = [] if snapshot is None else _tables(snapshot, texts)
    return {"trouble": parts.watch.trouble, "documents": DOCUMENTS, "tables": tables}


def _tables(snapshot: Snapshot, texts: Texts) -> list[dict[str, Any]]:
    measured = select(REGISTERS, "input", "r", "measurement")
    written = select(REGISTERS, "holding", "rw")
    discretes = select(REGISTERS, "discrete", "r")
    return [
        {
            "name": "measurement_block",
            "rows": [
                _row(row, ("input", "holding"), snapshot.words, MEASUREMENTS.start, snapshot.values[row.name])
                for row in measured
                if not row.spare
            ],
        },
        {
            "name": "bars_block",
            "rows": [
                _row(row, ("input", "holding"), snapshot.bar_words, BARS.start, snapshot.bars[row.name])
                for row in select(REGISTERS, "input", "r", "bars")
                if not row.spare and snapshot.bars
            ],
        },
        {
            "name": "set_point_block",
            "rows": [
                _row(row, ("holding",), snapshot.set_point_words, SET_POINTS.start, snapshot.set_points[row.name])
                for row in written
            ],
        },
        {
            "name": "bit_block",
            "rows": [_bit(row, texts, level=snapshot.discretes[row.name]) for row in discretes if not row.spare],
        },
    ]


def _row(
    row: Register, tables: tuple[Table, ...], words: tuple[int, ...], start: int, value: float | None
) -> dict[str, Any]:
    own = words[row.address - start : row.end - start]
    return {
        "name": row.name,
        "address": row.address,
        "modicon": ", ".join(str(export.modicon(row, table)) for table in tables),
        "words": " ".join(f"{word:04X}" for word in own),
        "value": ": ".join([value_in_words(row.name, value), *_names(row.name, value)]),
        "text": row.text,
    }


def _names(word: str, value: float | None) -> list[str]:
    """Names of the bits that are set in a word of bits, joined; nothing where it has none."""
    names = [bit.name for bit in _ALL_BITS.get(word, ()) if int(value or 0) >> bit.bit & 1]
    return [", ".join(names)] if names else []


def _bit(row: Register, texts: Texts, *, level: bool) -> dict[str, Any]:
    return {
        "name": row.name,
        "address": row.address,
        "modicon": export.modicon(row, "discrete"),
        "words": str(int(level)),
        "value": texts("on" if level else "off"),
        "text": row.text,
    }
