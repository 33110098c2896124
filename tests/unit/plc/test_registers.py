"""The register map: its rules, and values encoded and decoded again."""

import ctypes
import dataclasses
import math
import re
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plc import registers
from plc.codes import CODES
from plc.process_image import (
    VALUE_NAMES,
    ProcessImage,
    decode,
    decode_discretes,
    decode_set_points,
    encode,
    encode_set_points,
)
from plc.registers import REGISTERS
from plc.rows import Register, check

INTEGERS = {"u16": ctypes.c_uint16, "i16": ctypes.c_int16, "u32": ctypes.c_uint32, "u64": ctypes.c_uint64}
SET_POINT_BOUNDS = {
    "target_diameter": (10, 655.34),
    "tolerance_plus": (0.01, 50),
    "tolerance_minus": (0.01, 50),
    "steel_temperature": (100, 1400),
    "expansion_grade": (1, 99),
    "product_id": (None, None),
    "plc_heartbeat": (None, None),
}
ROWS = {row.name: row for row in REGISTERS}
BLOCK = [row for row in REGISTERS if row.block == "measurement"]
RINGS = [row for row in REGISTERS if row.block in {"reading_ring", "ingot_ring"}]

# the contract with PLC programmers, written down a second time: these names exist in every version
BLOCK_NAMES = re.findall(
    r"\w+",
    """
    map_version heartbeat sequence sequence_check device_state status_word validity reason_word
    measurement_age timestamp diameter expanded_uncertainty diameter_cold expanded_uncertainty_cold
    diameter_virtual_board weighted_deviation trust deviation decision correction alignment_quality
    plane_height windows_kept windows_total bar_sequence bar_min bar_mean bar_max ingot_orientation
    ingot_confidence ingot_sequence ingot_validity ingot_age ssim_top ssim_bottom alarm_word frames_dropped
    cycle_time fault_word test_float test_u32 diameter_u16 expanded_uncertainty_u16 diameter_cold_u16 trust_u16
    deviation_i16 correction_i16
""",
)
SET_POINT_NAMES = re.findall(
    r"\w+",
    """
    target_diameter tolerance_plus tolerance_minus steel_temperature expansion_grade product_id
    plc_heartbeat
""",
)
ALARM_NAMES = re.findall(
    r"\w+",
    """
    alarm_wrong_orientation alarm_out_of_tolerance alarm_low_trust alarm_camera alarm_stale
    alarm_calibration alarm_plc_silent alarm_internal
""",
)
STATUS_NAMES = ["measurement_valid", "bar_present", "ingot_present", "running", "simulated"]


def words_of(image: ProcessImage) -> tuple[int, ...]:
    return struct.unpack(">120H", image.words)


def at(image: ProcessImage, name: str) -> bytes:
    row = ROWS[name]
    return image.words[2 * row.address : 2 * row.end]


def changed(which: str, **fields: object) -> list[Register]:
    return [dataclasses.replace(row, **fields) if row.name == which else row for row in REGISTERS]


def test_the_register_map_passes_the_check_of_every_version():
    check(REGISTERS)


@pytest.mark.parametrize("name", BLOCK_NAMES)
def test_a_measurement_stands_at_one_address_in_both_word_tables(name):
    assert ROWS[name].tables == ("input", "holding")
    assert ROWS[name].access == "r"


@pytest.mark.parametrize("name", SET_POINT_NAMES)
def test_a_set_point_is_a_writable_holding_register_outside_of_the_block(name):
    assert ROWS[name].tables == ("holding",)
    assert ROWS[name].access == "rw"
    assert ROWS[name].address >= 200


def test_bits_stand_where_the_design_puts_them():
    assert [ROWS[name].address for name in ALARM_NAMES] == list(range(8))
    assert {ROWS[name].tables for name in ALARM_NAMES} == {("coil", "discrete")}
    assert [ROWS[name].address for name in STATUS_NAMES] == [16, 17, 18, 19, 20]
    assert [ROWS[name].address for name in ("acknowledge", "hold", "keep_pictures")] == [32, 33, 42]
    shelves = [ROWS[f"shelve_{name.removeprefix('alarm_')}"].address for name in ALARM_NAMES]
    assert shelves == list(range(34, 42))


def test_set_points_may_be_what_the_design_allows_and_nothing_beside():
    """Bounds of the contract with PLC programmers, written down a second time."""
    bounds = {name: (ROWS[name].lower, ROWS[name].upper) for name in SET_POINT_BOUNDS}
    assert bounds == SET_POINT_BOUNDS


def test_codes_are_the_numbers_of_the_contract():
    assert {
        name: {code: text.partition(",")[0] for code, text in codes.texts().items()} for name, codes in CODES.items()
    } == {
        "device_state": {0: "good", 1: "maintenance required", 2: "out of specification", 3: "test", 4: "failure"},
        "validity": {0: "none", 1: "valid", 2: "valid with reasons"},
        "decision": {0: "none", 1: "in", 2: "out", 3: "undecided"},
        "ingot_orientation": {0: "none", 1: "top", 2: "bottom", 3: "undecided"},
        "ingot_validity": {0: "none", 1: "valid", 2: "valid with reasons"},
    }


@pytest.mark.parametrize("row", [row for row in REGISTERS if row.type in INTEGERS], ids=lambda row: row.name)
def test_integers_hold_what_ctypes_gives_their_words(row):
    kind = INTEGERS[row.type]
    lowest, highest = row.raw_range
    assert [kind(lowest).value, kind(highest).value] == [lowest, highest]
    assert [kind(lowest - 1).value, kind(highest + 1).value] == [highest, lowest], "one beyond wraps round"


def test_the_block_is_120_words_without_a_hole():
    covered = sorted(word for row in BLOCK for word in range(row.address, row.end))
    assert covered == list(range(120))
    assert BLOCK[0].name == "sequence"
    assert max(BLOCK, key=lambda row: row.address).name == "sequence_check"


@pytest.mark.parametrize(
    ("rows", "named"),
    [
        (changed("diameter", address=17), "diameter"),
        (changed("diameter", address=18), "expanded_uncertainty"),
        (changed("cycle_time", name="diameter"), "repeated name"),
        (changed("diameter", tables=("input",)), "input and holding"),
        (changed("diameter", tables=("coil",)), "type of diameter"),
        (changed("diameter", access="rw"), "write access"),
        (changed("sequence", name="first"), "source of sequence_check"),
        (changed("sequence_check", shows="heartbeat"), "last word"),
        (changed("sequence_check", address=130), "hole before sequence_check"),
        (changed("hold", address=40), "overlap of hold"),
        (changed("acknowledge", address=31), "start of commands"),
        (changed("plc_heartbeat", address=65536), "address of plc_heartbeat"),
        (changed("target_diameter", upper=700), "bounds of target_diameter"),
        (changed("target_diameter", upper=None), "missing bound"),
        (changed("diameter_u16", shows="circumference"), "source of diameter_u16"),
        (changed("diameter", block=None), "block of diameter"),
        (changed("target_diameter", block="measurement"), "block of target_diameter"),
        (changed("reading_ring_index", name="reading_ring_pointer"), "first word of the reading_ring block"),
        (changed("reading_3_diameter", tables=("input",)), "reading_ring block"),
        (changed("ingot_ring_index", address=421), "overlap of ingot_ring_index"),
        (changed("ingot_7_orientation", address=520), "hole before ingot_7_orientation"),
        ([row for row in REGISTERS if row.name != "heartbeat"], "hole before device_state"),
    ],
)
def test_check_refuses_a_broken_map_and_says_where(rows, named):
    with pytest.raises(ValueError, match=named):
        check(rows)


def test_check_refuses_a_value_that_does_not_stand_at_a_multiple_of_its_length():
    places = {"frames_dropped": 9, "measurement_age": 11}
    rows = [dataclasses.replace(row, address=places.get(row.name, row.address)) for row in REGISTERS]
    with pytest.raises(ValueError, match="alignment of frames_dropped"):
        check(rows)


def test_check_refuses_a_block_that_one_request_cannot_read():
    last = ROWS["sequence_check"]
    more = [dataclasses.replace(ROWS["spare_79"], name=f"spare_{n}", address=n) for n in range(119, 126)]
    rows = [*(row for row in REGISTERS if row is not last), *more, dataclasses.replace(last, address=126)]
    with pytest.raises(ValueError, match="length of the measurement block"):
        check(rows)


def test_a_float_is_most_significant_word_first_and_can_be_turned_round():
    big = encode({"diameter": 265.5})
    little = encode({"diameter": 265.5}, word_order="little")
    assert at(big, "diameter") == bytes.fromhex("4384 c000")
    assert at(little, "diameter") == bytes.fromhex("c000 4384")
    assert at(big, "test_u32") == bytes.fromhex("1234 5678")
    assert at(little, "test_u32") == bytes.fromhex("5678 1234")
    assert at(big, "test_float") == struct.pack(">f", 123.456)


def test_a_64_bit_time_stamp_turns_its_four_words_round():
    assert at(encode({"timestamp": 0x0001_0002_0003_0004}), "timestamp").hex() == "0001000200030004"
    little = encode({"timestamp": 0x0001_0002_0003_0004}, word_order="little")
    assert at(little, "timestamp").hex() == "0004000300020001"


@pytest.mark.parametrize("nothing", [None, math.nan, -math.nan, math.inf, -math.inf, 1e39])
def test_no_value_is_a_quiet_nan_and_the_reserved_integers(nothing):
    image = encode({"diameter": nothing, "deviation": nothing, "measurement_age": nothing, "ingot_age": nothing})
    assert at(image, "diameter") == bytes.fromhex("7fc00000")
    assert at(image, "diameter_u16") == bytes.fromhex("ffff")
    assert at(image, "deviation_i16") == bytes.fromhex("8000")
    assert at(image, "measurement_age") == bytes.fromhex("ffff")
    assert at(image, "ingot_age") == bytes.fromhex("ffffffff")


def test_nothing_at_all_gives_no_value_everywhere_and_never_zero_for_a_measurement():
    values = decode(words_of(encode({})))
    assert values["map_version"] == 5
    assert values["sequence"] == values["validity"] == values["alarm_word"] == 0
    measured = [row for row in BLOCK if row.unit and row.constant is None]
    assert [row.name for row in measured if values[row.name] is not None] == []


@pytest.mark.parametrize(
    ("diameter", "word"),
    [(0.005, 0), (0.015, 2), (265.5, 26550), (655.34, 65534), (655.35, 0xFFFF), (700.0, 0xFFFF), (-1.0, 0xFFFF)],
)
def test_a_scaled_integer_rounds_half_to_even_and_is_no_value_out_of_range(diameter, word):
    assert at(encode({"diameter": diameter}), "diameter_u16") == struct.pack(">H", word)


@pytest.mark.parametrize(("deviation", "word"), [(-0.5, -50), (-327.67, -32767), (-400, -32768), (400, -32768)])
def test_a_signed_scaled_integer_keeps_its_sign_and_never_wraps(deviation, word):
    assert at(encode({"deviation": deviation}), "deviation_i16") == struct.pack(">h", word)


def test_counters_wrap_as_counters_do():
    image = encode({"sequence": 65536 + 7, "heartbeat": 65535, "frames_dropped": 2**32 + 1})
    values = decode(words_of(image))
    assert (values["sequence"], values["sequence_check"]) == (7, 7)
    assert values["heartbeat"] == 65535
    assert values["frames_dropped"] == 1


def test_what_repeats_another_value_is_filled_in():
    image = encode({"alarm_word": 0b10010, "measurement_valid": True, "simulated": 1, "running": False})
    values = decode(words_of(image))
    assert values["status_word"] == 0b10001
    assert values["alarm_word"] == 0b10010
    assert image.coils == 0b10010
    assert image.discretes == 0b10001 << 16 | 0b10010
    bits = [bool(image.discretes >> n & 1) for n in range(24)]
    assert {name for name, on in decode_discretes(bits).items() if on} == {
        "alarm_out_of_tolerance",
        "alarm_stale",
        "measurement_valid",
        "simulated",
    }


@pytest.mark.parametrize(
    "name", ["diametre", "sequence_check", "diameter_u16", "status_word", "map_version", "test_float", "spare_79"]
)
def test_a_name_that_is_unknown_or_derived_is_a_wrong_call(name):
    with pytest.raises(ValueError, match=name):
        encode({name: 1})


def test_wrong_calls_name_the_argument():
    with pytest.raises(TypeError, match="values"):
        encode({"diameter": "265"})  # type: ignore[dict-item]
    with pytest.raises(ValueError, match="word_order"):
        encode({}, word_order="middle")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="words"):
        decode([0] * 119)
    with pytest.raises(ValueError, match="bits"):
        decode_discretes([False] * 20)


def values_strategy() -> st.SearchStrategy[dict[str, float | int | None]]:
    fields = {}
    for row in (*BLOCK, *RINGS[:30]):
        if row.name in VALUE_NAMES:
            number = st.floats(width=32, allow_nan=False, allow_infinity=False)
            lowest, highest = row.raw_range
            value = (
                number
                if row.type == "f32"
                else st.integers(lowest, highest).map(lambda n, s=row.scale: n * s if s != 1 else n)
            )
            fields[row.name] = value if row.invalid is None else st.none() | value
    return st.fixed_dictionaries(fields)


@given(values_strategy(), st.sampled_from(["big", "little"]))
def test_what_is_encoded_is_decoded_in_either_word_order(values, word_order):
    decoded = all_decoded(encode(values, word_order=word_order), word_order)
    for name, value in values.items():
        row = ROWS[name]
        if row.scale == 1:
            assert decoded[name] == (None if value == row.invalid else value)
        else:
            gone = value is None or round(value / row.scale) == row.invalid
            assert decoded[name] == (None if gone else pytest.approx(value, abs=1e-6))


def all_decoded(image: ProcessImage, word_order: str) -> dict[str, float | int | None]:
    contents = {
        "measurement": image.words,
        "reading_ring": image.reading_ring,
        "ingot_ring": image.ingot_ring,
        "bars": image.bars,
    }
    decoded = {}
    for block, data in contents.items():
        words = struct.unpack(f">{len(data) // 2}H", data)
        decoded |= decode(words, block=block, word_order=word_order)
    return decoded


def test_a_ring_is_one_request_that_begins_with_its_index_and_holds_eight_slots():
    for area, name, slot in (
        (registers.READING_RING, "reading", ["timestamp", "diameter", "expanded_uncertainty", "trust", "validity"]),
        (registers.INGOT_RING, "ingot", ["timestamp", "orientation", "confidence", "sequence"]),
    ):
        assert len(area) <= 125
        assert ROWS[f"{name}_ring_index"].address == area.start == {"reading": 300, "ingot": 420}[name]
        assert all(ROWS[f"{name}_{n}_{field}"].address in area for n in range(8) for field in slot)
        assert ROWS[f"{name}_1_timestamp"].address - ROWS[f"{name}_0_timestamp"].address == 12
        assert f"{name}_8_timestamp" not in ROWS


def test_an_empty_ring_holds_no_values_and_never_zero_for_a_measurement():
    decoded = all_decoded(encode({}), "big")
    for row in RINGS:
        if row.name in decoded:
            assert decoded[row.name] == (0 if row.invalid is None else None)


def test_addresses_of_version_1_have_not_moved():
    places = {"heartbeat": 2, "validity": 5, "timestamp": 12, "diameter": 16, "trust": 28, "decision": 54}
    places |= {"bar_sequence": 57, "test_float": 62, "diameter_u16": 66, "sequence_check": 119, "target_diameter": 200}
    assert {name: ROWS[name].address for name in places} == places


@given(st.one_of(st.floats(), st.integers(), st.booleans(), st.none()))
def test_no_number_at_all_makes_encoding_fail(value):
    image = encode(dict.fromkeys(VALUE_NAMES, value))
    assert len(image.words) == 240
    assert 0 <= image.discretes < 2**21


def test_set_points_accept_zero_and_their_bounds_only():
    target = ROWS["target_diameter"]
    assert [target.accepts(raw) for raw in (0, 1, 999, 1000, 65534, 65535)] == [1, 0, 0, 1, 1, 0]
    temperature = ROWS["steel_temperature"]
    assert [temperature.accepts(raw) for raw in (-1, 0, 99, 100, 1400, 1401)] == [0, 1, 0, 1, 1, 0]
    assert ROWS["product_id"].accepts(2**32 - 1)


def test_set_points_are_decoded_as_the_numbers_in_their_words():
    words = struct.pack(">HHHhHHHH", 26550, 40, 30, -5, 0x0001, 0x0002, 3, 65535)
    points = decode_set_points(words)
    assert points["target_diameter"] == 26550
    assert points["steel_temperature"] == -5
    assert points["product_id"] == 0x00010002
    assert points["plc_heartbeat"] == 65535
    assert decode_set_points(words, word_order="little")["product_id"] == 0x00020001


def test_set_points_are_encoded_as_they_are_decoded():
    numbers = {"target_diameter": 26550, "steel_temperature": 1050, "product_id": 0x12345678, "plc_heartbeat": 9}
    for order in ("big", "little"):
        decoded = decode_set_points(encode_set_points(numbers, word_order=order), word_order=order)
        assert decoded == {name: numbers.get(name, 0) for name in SET_POINT_NAMES}
