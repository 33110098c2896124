"""The register map as Markdown, CSV, JSON and IEC 61131-3 text, read back."""

import csv
import io
import json
import re

import pytest
from blark import transform as tree
from blark.parse import parse_source_code

from appliance.diagnostics.named_bits import named_bits
from plc import export
from plc.registers import MAP_VERSION, REGISTERS
from plc.structured_text.program import to_structured_text

KEYS = ["name", "table", "address", "words", "type", "unit", "scale", "invalid", "access", "text"]
TYPES = {"u16", "i16", "u32", "i32", "u64", "f32", "bool"}
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


def test_bits_and_codes_are_named(entries):
    document = json.loads(export.to_json(named_bits()))
    names = {entry["name"] for entry in entries}
    bits = {(one["register"], one["bit"]): one["name"] for one in document["bits"]}
    assert bits["status_word", 4] == "simulated"
    assert bits["alarm_word", 1] == "alarm_out_of_tolerance"
    assert bits["fault_word", 0] == "camera_lost"
    assert bits["reason_word", 0] == "no_bar"
    assert len(bits) == len(document["bits"])
    codes = {(one["register"], one["value"]): one["text"] for one in document["codes"]}
    assert codes["decision", 3] == "undecided"
    assert {register for register, _ in (*bits, *codes)} <= names


def test_csv_has_what_import_tools_ask_for():
    rows = {(row["name"], row["table"]): row for row in csv.DictReader(io.StringIO(export.to_csv(named_bits())))}
    target = rows["target_diameter", "holding"]
    assert (target["address"], target["address_1_based"], target["modicon"]) == ("200", "201", "40201")
    assert target["functions"] == "3 6 16 23"
    assert (target["lower"], target["upper"]) == ("10", "655.34")
    assert rows["alarm_camera", "coil"]["modicon"] == "00004"
    assert rows["diameter", "input"]["modicon"] == "30017"
    assert "4 simulated" in rows["status_word", "input"]["bits"]
    assert "0 camera_lost" in rows["fault_word", "input"]["bits"]
    assert rows["decision", "input"]["codes"].startswith("0 none; 1 in")


def test_csv_with_a_byte_order_mark_is_read_as_utf_8_by_excel():
    text = export.to_csv(byte_order_mark=True)
    assert text.encode("utf-8").startswith(b"\xef\xbb\xbf")
    assert text[1:] == export.to_csv()


def test_markdown_has_both_notations_and_the_functions():
    text = export.to_markdown(named_bits())
    assert "| diameter | 16 (30017) |" in text
    assert "| diameter | 16 (40017) |" in text
    assert "## Coils: read with function 1, written with 5, 15" in text
    assert "- 0 `camera_lost`:" in text


SIZES = {"UINT": 2, "INT": 2, "UDINT": 4, "REAL": 4, "ULINT": 8, "BOOL": 1}


class Structures:
    """Structures of a text, read by blark, laid out as a compiler that aligns every value does."""

    def __init__(self, text: str) -> None:
        items = parse_source_code(text).transform().items
        declared = [item.declaration for item in items if isinstance(item, tree.DataTypeDeclaration)]
        self.members = {str(one.name): self._members(one) for one in declared}

    @staticmethod
    def _members(structure) -> list[tuple[str, str]]:
        return [(str(variable.name), str(item.init)) for item in structure.declarations for variable in item.variables]

    def size(self, kind: str) -> int:
        return self.layout(kind)[1] if kind in self.members else SIZES[kind]

    def alignment(self, kind: str) -> int:
        return (
            max(self.alignment(self.split(inner)[1]) for _, inner in self.members[kind])
            if kind in self.members
            else SIZES[kind]
        )

    @staticmethod
    def split(kind: str) -> tuple[int, str]:
        found = re.fullmatch(r"ARRAY \[(\d+)\.\.(\d+)\] OF (\w+)", kind)
        return (1, kind) if found is None else (int(found[2]) - int(found[1]) + 1, found[3])

    def layout(self, structure: str) -> tuple[dict[str, int], int]:
        """Offset of every member, and the size, in bytes."""
        offset, offsets = 0, {}
        for name, kind in self.members[structure]:
            count, inner = self.split(kind)
            offset = -(-offset // self.alignment(inner)) * self.alignment(inner)
            offsets[name] = offset
            offset += count * self.size(inner)
        return offsets, -(-offset // self.alignment(structure)) * self.alignment(structure)


@pytest.fixture(scope="module")
def structures() -> Structures:
    return Structures(to_structured_text())


START = {row.name: row.address for row in REGISTERS}


@pytest.mark.parametrize("structure", ["HOTGAUGE_MEASUREMENT", "HOTGAUGE_SET_POINTS"])
def test_a_compiler_that_aligns_structures_finds_every_value_at_its_address(structures, structure):
    offsets, _ = structures.layout(structure)
    first = START[next(iter(offsets))]
    assert {name: first + offset // 2 for name, offset in offsets.items()} == {name: START[name] for name in offsets}


@pytest.mark.parametrize(
    ("slot", "block", "what"), [("READING", "reading_ring", "reading"), ("INGOT", "ingot_ring", "ingot")]
)
def test_the_slots_of_a_ring_are_an_array_of_structures_at_their_addresses(structures, slot, block, what):
    ring, size = structures.layout(f"HOTGAUGE_{slot}_RING")
    fields, slot_size = structures.layout(f"HOTGAUGE_{slot}")
    first = START[f"{block}_index"]
    for number in range(8):
        for field, offset in fields.items():
            address = first + (ring["slots"] + number * slot_size + offset) // 2
            assert address == START[f"{what}_{number}_{field}"]
    assert size == 200


def test_structured_text_holds_every_bit_in_order_of_address(structures):
    assert len(structures.members["HOTGAUGE_ALARMS"]) == 16
    assert [name for name, _ in structures.members["HOTGAUGE_COMMANDS"]][:3] == [
        "acknowledge",
        "hold",
        "shelve_wrong_orientation",
    ]
    assert len(structures.members["HOTGAUGE_DISCRETE_INPUTS"]) == 21


def test_every_bit_and_code_is_a_named_constant_once():
    text = to_structured_text(named_bits())
    found = re.findall(r"^ +(HOTGAUGE_\w+) : INT := (\d+);", text, flags=re.MULTILINE)
    assert len(dict(found)) == len(found)
    assert {"HOTGAUGE_FAULT_BIT_CAMERA_LOST": "0", "HOTGAUGE_DECISION_UNDECIDED": "3"}.items() <= dict(found).items()


def test_the_source_for_tia_is_the_same_program_in_its_own_notation():
    """What TIA Portal wants differs by # before own variables, quotes around blocks, and the timer's type."""
    codesys, tia = to_structured_text(), to_structured_text(dialect="tia")
    block = tia[tia.index('FUNCTION_BLOCK "HOTGAUGE"') :]
    body = block[block.index("BEGIN\n") + 6 : block.index("END_FUNCTION_BLOCK")]
    assert re.sub(r'(?<!16)#|"', "", body) == codesys[codesys.index("(* poll") : codesys.index("END_FUNCTION_BLOCK")]
    code = re.sub(r"\(\*.*?\*\)", "", body)
    words = re.findall(r'(?<![\w#."])[a-z_]\w*', code)
    assert set(words) == {"high", "low"}  # named parameters; every variable has its #
    assert "TON_TIME" in block
    heads = re.findall(r"^FUNCTION (\w+) : (\w+)", codesys, flags=re.MULTILINE)
    assert re.findall(r'^FUNCTION "(\w+)" : (\w+)', tia, flags=re.MULTILINE) == heads
    assert heads


def test_a_member_says_its_address_its_text_and_its_unit():
    text = to_structured_text()
    diameter = re.findall(r"^ +diameter : REAL;.*", text, flags=re.MULTILINE)[0]
    assert re.search(r"\(\* 16: .+, mm \*\)", diameter)
    sequence = re.findall(r"^ +sequence : UINT;.*", text, flags=re.MULTILINE)[0]
    assert re.search(r"\(\* 0: .+ of the block \*\)", sequence), "it has no unit"


def test_the_logic_for_rockwell_uses_only_declared_tags_and_closes_what_it_opens():
    text = to_structured_text(dialect="rockwell")
    declared = set(re.findall(r"^//   (?:Input|InOut|Output|Local) +(\w+)", text, flags=re.MULTILINE))
    logic = text[text.index("// Logic:") + 9 :]
    used = set(re.findall(r"(?<![\w.#])[a-z]\w*", logic))
    assert used == declared
    assert len(re.findall(r"\bIF\b", logic)) == len(re.findall(r"\bEND_IF\b", logic))
    assert "TRUE" not in logic  # literals are 1 and 0 there


def test_an_unknown_dialect_is_named():
    with pytest.raises(ValueError, match="dialect"):
        to_structured_text(dialect="s5")
