import csv
import io
import json
import re

import pytest

from plc import export
from plc.registers import MAP_VERSION, REGISTERS

KEYS = ["name", "table", "address", "words", "type", "unit", "scale", "invalid", "access", "text"]
TYPES = {"u16", "i16", "u32", "i32", "u64", "f32", "bool"}
IEC_BYTES = {"UINT": 2, "INT": 2, "UDINT": 4, "REAL": 4, "ULINT": 8}
ROWS_PER_TABLE = {(row.name, table, row.address) for row in REGISTERS for table in row.tables}


@pytest.fixture(scope="module")
def entries() -> list[dict]:
    document = json.loads(export.to_json())
    assert document["map_version"] == MAP_VERSION
    return document["registers"]


def test_json_has_one_row_per_table_and_exactly_the_agreed_keys(entries):
    assert all(list(entry) == KEYS for entry in entries)
    assert {(e["name"], e["table"], e["address"]) for e in entries} == ROWS_PER_TABLE
    assert len(entries) == len(ROWS_PER_TABLE)


def test_json_rows_hold_only_what_the_contract_allows(entries):
    assert {entry["table"] for entry in entries} == {"input", "holding", "discrete", "coil"}
    assert {entry["type"] for entry in entries} <= TYPES
    assert {entry["access"] for entry in entries} == {"r", "rw"}
    widths = {"u16": 1, "i16": 1, "u32": 2, "i32": 2, "f32": 2, "u64": 4, "bool": 1}
    assert all(entry["words"] == widths[entry["type"]] for entry in entries)
    assert all(entry["text"] for entry in entries)


def test_json_says_which_number_means_no_value(entries):
    invalid = {entry["name"]: entry["invalid"] for entry in entries}
    assert invalid["diameter"] == "NaN"
    assert invalid["diameter_u16"] == 65535
    assert invalid["deviation_i16"] == -32768
    assert invalid["sequence"] is None


def test_json_gives_the_bounds_of_a_set_point_in_its_text(entries):
    (target,) = (entry for entry in entries if entry["name"] == "target_diameter")
    assert "10 to 655.34" in target["text"]


def test_csv_says_the_same_as_json(entries):
    rows = list(csv.DictReader(io.StringIO(export.to_csv())))
    assert [[row[key] for key in KEYS] for row in rows] == [
        ["" if entry[key] is None else str(entry[key]) for key in KEYS] for entry in entries
    ]


def test_markdown_has_a_row_of_equal_width_for_every_entry(entries):
    rows = [line for line in export.to_markdown().splitlines() if line.startswith("| ")]
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {10}
    assert len(rows) == len(entries) + 2 * 4


def structures(text: str) -> dict[str, list[tuple[str, str]]]:
    without_comments = re.sub(r"\(\*.*?\*\)", "", text, flags=re.DOTALL)
    pattern = r"TYPE\s+(\w+)\s*:\s*STRUCT\s+(.*?)END_STRUCT;\s*END_TYPE"
    found = re.findall(pattern, without_comments, flags=re.DOTALL)
    assert re.sub(pattern, "", without_comments, flags=re.DOTALL).strip() == ""  # nothing else stands there
    return {name: re.findall(r"(\w+)\s*:\s*(\w+)\s*;", body) for name, body in found}


@pytest.mark.parametrize(
    "structure", ["HOTGAUGE_MEASUREMENT", "HOTGAUGE_SET_POINTS", "HOTGAUGE_READING_RING", "HOTGAUGE_INGOT_RING"]
)
def test_a_compiler_that_aligns_structures_finds_every_value_at_its_address(structure):
    members = structures(export.to_structured_text())[structure]
    start = {row.name: row.address for row in REGISTERS}
    offset = 2 * start[members[0][0]]
    for name, iec_type in members:
        size = IEC_BYTES[iec_type]
        offset = -(-offset // size) * size
        assert offset == 2 * start[name]
        offset += size


def test_structured_text_holds_every_bit_in_order_of_address():
    bits = structures(export.to_structured_text())
    assert len(bits["HOTGAUGE_ALARMS"]) == 16
    assert [name for name, _ in bits["HOTGAUGE_COMMANDS"]] == ["acknowledge", "hold"]
    assert len(bits["HOTGAUGE_DISCRETE_INPUTS"]) == 21
    assert {iec for name in ("HOTGAUGE_ALARMS", "HOTGAUGE_COMMANDS") for _, iec in bits[name]} == {"BOOL"}
