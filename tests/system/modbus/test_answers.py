"""Every kind of request, byte for byte."""

import random
import struct

import pytest
from modbus_wire import LIVE, Wire, exception, read, served, write_and_read, write_coils, write_registers

from plc.process_image import encode
from plc.server import ModbusServer


def test_an_input_register_is_answered_byte_for_byte(wire):
    wire.send(bytes.fromhex("1234 0000 0006 01 04 0010 0002"))
    assert wire.receive_frame() == bytes.fromhex("1234 0000 0007 01 04 04") + struct.pack(">f", 265.53)


@pytest.mark.parametrize("function", [3, 4])
def test_the_whole_block_is_one_request_and_the_same_in_both_tables(wire, function):
    answer = wire.ask(read(function, 0, 120))
    assert answer[:2] == bytes((function, 240))
    assert answer[2:] == encode(LIVE).words


@pytest.mark.parametrize("function", [1, 2])
def test_alarm_bits_are_the_same_as_coils_and_as_discrete_inputs(wire, function):
    assert wire.ask(read(function, 0, 16)) == bytes((function, 2, 0b1001_0010, 0))
    assert wire.ask(read(function, 1, 3)) == bytes((function, 1, 0b001))
    assert wire.ask(read(function, 4, 9)) == bytes((function, 2, 0b1001, 0))


def test_status_bits_follow_the_alarms_as_discrete_inputs(wire):
    assert wire.ask(read(2, 16, 5)) == bytes((2, 1, 0b01001))
    assert wire.ask(read(2, 0, 21)) == bytes((2, 3, 0b1001_0010, 0, 0b01001))


@pytest.mark.parametrize(
    ("function", "start", "count"),
    [
        *[(function, *wanted) for function in (3, 4) for wanted in ((624, 1), (624, 2), (623, 107), (65535, 125))],
        *[(1, start, count) for start, count in ((43, 1), (42, 23), (0, 65), (65535, 2000))],
        *[(2, start, count) for start, count in ((21, 1), (20, 45), (0, 2000))],
    ],
)
def test_a_read_that_begins_behind_the_last_row_or_ends_behind_the_map_answers_2(wire, function, start, count):
    assert wire.ask(read(function, start, count)) == exception(function, 2)


@pytest.mark.parametrize("function", [3, 4])
@pytest.mark.parametrize("size", [8, 10, 16, 32, 64, 100, 120, 125])
def test_aligned_blocks_of_words_over_the_whole_map_hold_its_rows_and_no_values(wire, function, size):
    wire.ask(write_registers(200, 26550, 40))
    image = encode(LIVE)
    expected = dict.fromkeys(range(625), 0xFFFF)
    for start, block in ((0, image.words), (300, image.reading_ring), (420, image.ingot_ring), (540, image.bars)):
        expected |= dict(enumerate(struct.unpack(f">{len(block) // 2}H", block), start))
    if function == 3:
        expected |= dict(zip(range(200, 209), (26550, 40, 0, 0, 0, 0, 0, 0), strict=False))
    for start in range(0, 625 - size, size):
        words = struct.unpack(f">{size}H", wire.ask(read(function, start, size))[2:])
        assert dict(enumerate(words, start)) == {n: expected[n] for n in range(start, start + size)}


@pytest.mark.parametrize("size", [16, 32, 64])
def test_aligned_blocks_of_bits_hold_alarms_states_and_commands_and_zeros(wire, size):
    wire.ask(write_coils(32, False, True))
    coils = LIVE["alarm_word"] | 0b10 << 32
    discretes = LIVE["alarm_word"] | 0b01001 << 16
    for function, last, expected in ((1, 34, coils), (2, 21, discretes)):
        for start in range(0, last, size):
            answer = wire.ask(read(function, start, size))
            assert int.from_bytes(answer[2:], "little") == expected >> start & (1 << size) - 1


@pytest.mark.parametrize(
    "request_",
    [
        *[read(function, 0, count) for function in (1, 2) for count in (0, 2001, 65535)],
        *[read(function, 0, count) for function in (3, 4) for count in (0, 126, 65535)],
        *[read(function, 60000, 0) for function in (1, 2, 3, 4)],  # quantity is judged before the range
        *[bytes((function, 0, 0, 0)) for function in (1, 2, 3, 4, 5, 6, 15, 16, 23)],
        *[bytes((function,)) for function in (1, 2, 3, 4, 5, 6, 15, 16, 23)],
        *[read(function, 0, 1) + b"\0" for function in (1, 2, 3, 4, 5, 6)],
        struct.pack(">BHHB", 16, 200, 0, 0),
        struct.pack(">BHHB", 16, 200, 124, 248) + bytes(244),
        struct.pack(">BHHBH", 16, 200, 1, 4, 0),
        struct.pack(">BHHBH", 16, 200, 2, 4, 0),
        struct.pack(">BHHB", 15, 32, 0, 0),
        struct.pack(">BHHB", 15, 0, 1969, 247) + bytes(247),  # 1968 is the most of one request
        struct.pack(">BHHBB", 15, 32, 1, 2, 0),
        struct.pack(">BHHB", 15, 32, 9, 2) + b"\0",
        struct.pack(">BHH", 5, 32, 0x1234),
        struct.pack(">BHH", 5, 32, 0x0001),
        struct.pack(">BHH", 5, 32, 0xFFFF),
        struct.pack(">BHH", 5, 9999, 0x1234),
        write_and_read(0, 0, 200, 1),
        write_and_read(0, 126, 200, 1),
        write_and_read(0, 1, 200),
        struct.pack(">BHHHHBH", 23, 0, 1, 200, 1, 4, 1),
    ],
)
def test_a_wrong_quantity_or_value_answers_3(wire, written, request_):
    assert wire.ask(request_) == exception(request_[0], 3)
    assert written == []


SERVED = {1, 2, 3, 4, 5, 6, 15, 16, 23, 43}


@pytest.mark.parametrize("function", sorted(set(range(256)) - SERVED))
def test_every_other_function_answers_1_with_its_own_code(wire, function):
    assert wire.ask(bytes((function, 0, 0, 0, 1))) == exception(function, 1)


@pytest.mark.parametrize("unit", [0, 1, 255])
def test_the_units_that_plcs_use_are_answered_as_the_same_unit(wire, unit):
    assert wire.ask(read(4, 0, 1), unit=unit) == bytes.fromhex("0402004d")


@pytest.mark.parametrize("unit", [2, 17, 247, 254])
def test_any_other_unit_is_a_silent_gateway_target(wire, unit):
    assert wire.ask(read(4, 0, 1), unit=unit) == exception(4, 11)
    assert wire.ask(write_registers(200, 26550), unit=unit) == exception(16, 11)


def test_one_set_point_is_written_echoed_told_and_read_back(wire, written):
    request = struct.pack(">BHH", 6, 200, 26550)
    assert wire.ask(request) == request
    assert written == [{"target_diameter": 26550}]
    assert wire.ask(read(3, 200, 1)) == bytes((3, 2)) + struct.pack(">H", 26550)


def test_all_set_points_are_written_in_one_request(wire, written):
    words = (26550, 40, 30, 1050, 0x1234, 0x5678, 2, 99)
    assert wire.ask(write_registers(200, *words)) == struct.pack(">BHH", 16, 200, 8)
    assert written == [
        {
            "target_diameter": 26550,
            "tolerance_plus": 40,
            "tolerance_minus": 30,
            "steel_temperature": 1050,
            "product_id": 0x12345678,
            "expansion_grade": 2,
            "plc_heartbeat": 99,
        }
    ]
    assert struct.unpack(">8H", wire.ask(read(3, 200, 8))[2:]) == words


def test_an_equal_write_does_nothing(wire, written):
    for _ in range(3):
        wire.ask(write_registers(200, 26550, 40, 30, 1050, 1, 2, 2, 99))
        wire.ask(write_coils(32, False, True))
    assert len(written) == 2


def test_a_plc_that_starts_with_zeros_never_sees_an_exception(wire, written):
    assert wire.ask(write_registers(200, *[0] * 8)) == struct.pack(">BHH", 16, 200, 8)
    assert wire.ask(write_coils(32, False, False)) == struct.pack(">BHH", 15, 32, 2)
    assert written == []


def test_a_set_point_can_be_taken_back_with_0(wire, written):
    wire.ask(write_registers(200, 26550))
    wire.ask(write_registers(200, 0))
    assert written[-1] == {"target_diameter": 0}


def test_each_word_of_the_product_number_is_writable_alone(wire, written):
    wire.ask(write_registers(204, 0xABCD))
    wire.ask(struct.pack(">BHH", 6, 205, 0xEF01))
    assert written == [{"product_id": 0xABCD0000}, {"product_id": 0xABCDEF01}]


def test_the_product_number_follows_the_word_order_of_the_image(server, wire, written):
    server.publish(encode(LIVE, word_order="little"))
    wire.ask(write_registers(204, 0x5678, 0x1234))
    assert written == [{"product_id": 0x12345678}]


def test_a_negative_temperature_is_out_of_bounds_and_not_a_large_one(wire):
    assert wire.ask(write_registers(203, 0xFFFF)) == exception(16, 3)


@pytest.mark.parametrize(
    ("address", "word"),
    [(200, 999), (200, 65535), (201, 5001), (202, 5001), (203, 99), (203, 1401), (206, 100)],
)
def test_a_set_point_out_of_bounds_answers_3_and_nothing_of_the_request_is_written(wire, written, address, word):
    good = [26550, 40, 30, 1050, 1, 2, 2, 99]
    good[address - 200] = word
    assert wire.ask(write_registers(200, *good)) == exception(16, 3)
    assert wire.ask(struct.pack(">BHH", 6, address, word)) == exception(6, 3)
    assert wire.ask(write_and_read(0, 1, 200, *good)) == exception(23, 3)
    assert wire.ask(read(3, 200, 8))[2:] == bytes(16)
    assert written == []


@pytest.mark.parametrize(
    "request_",
    [
        struct.pack(">BHH", 6, 16, 1),
        struct.pack(">BHH", 6, 120, 1),
        write_registers(0, 1),
        write_registers(199, 1, 26550),
        write_registers(207, 1, 1),
        write_registers(65535, 1, 1),
        struct.pack(">BHH", 5, 0, 0xFF00),
        struct.pack(">BHH", 5, 16, 0xFF00),
        struct.pack(">BHH", 5, 43, 0xFF00),
        write_coils(31, True, True),
        write_coils(42, True, True),
        write_coils(0, *[True] * 40),
        write_and_read(0, 1, 0, 1),
        write_and_read(624, 2, 200, 26550),  # the read half is refused before the write half acts
        write_and_read(0, 1, 207, 1, 1),
    ],
)
def test_a_write_outside_of_what_is_writable_answers_2_and_writes_nothing(wire, written, request_):
    assert wire.ask(request_) == exception(request_[0], 2)
    assert written == []
    assert wire.ask(read(3, 200, 8))[2:] == bytes(16)
    assert wire.ask(read(1, 32, 2)) == bytes((1, 1, 0))


def test_function_23_reads_what_it_has_just_written(wire, written):
    answer = wire.ask(write_and_read(200, 2, 201, 40))
    assert answer == bytes.fromhex("17 04 0000 0028")
    assert written == [{"tolerance_plus": 40}]


def test_commands_are_levels_and_told_on_change(wire, written):
    on, off = struct.pack(">BHH", 5, 32, 0xFF00), struct.pack(">BHH", 5, 32, 0)
    assert wire.ask(on) == on
    assert wire.ask(read(1, 32, 2)) == bytes((1, 1, 0b01))
    assert wire.ask(on) == on
    assert wire.ask(write_coils(32, True, True)) == struct.pack(">BHH", 15, 32, 2)
    assert wire.ask(off) == off
    assert written == [{"acknowledge": True}, {"hold": True}, {"acknowledge": False}]
    assert wire.ask(read(1, 33, 1)) == bytes((1, 1, 1))


def test_bits_beyond_the_quantity_of_a_coil_write_are_ignored(wire, written):
    wire.ask(struct.pack(">BHHBB", 15, 32, 1, 1, 0xFF))
    assert written == [{"acknowledge": True}]


def test_publishing_never_overwrites_what_the_plc_has_written(server, wire):
    wire.ask(write_registers(200, 26550))
    wire.ask(write_coils(32, False, True))
    server.publish(encode({"alarm_word": 0xFFFF}))
    assert wire.ask(read(3, 200, 1))[2:] == struct.pack(">H", 26550)
    assert wire.ask(read(1, 32, 2)) == bytes((1, 1, 0b10))


def test_a_write_that_cannot_be_acted_on_answers_4_and_stays_unwritten(wire, written):
    written.broken = True
    assert wire.ask(write_registers(200, 26550)) == exception(16, 4)
    assert wire.ask(write_coils(32, True)) == exception(15, 4)
    assert wire.ask(read(3, 200, 1))[2:] == bytes(2)
    written.broken = False
    assert wire.ask(write_registers(200, 26550))[0] == 16
    assert written == [{"target_diameter": 26550}]


@pytest.mark.parametrize("writes", ["none", "tls"])
def test_without_permission_a_write_answers_1_whatever_else_is_wrong_with_it(writes):
    server = ModbusServer("127.0.0.1", 0, writes=writes)
    with served(server), Wire(server.port) as wire:
        for request in (
            struct.pack(">BHH", 5, 32, 0x1234),
            struct.pack(">BHH", 6, 9999, 1),
            write_coils(32, True),
            write_registers(200, 26550),
            write_and_read(0, 1, 200, 26550),
        ):
            assert wire.ask(request) == exception(request[0], 1)
        assert wire.ask(read(3, 200, 8))[2:] == bytes(16)


def identified(answer: bytes) -> dict[int, bytes]:
    assert answer[:2] == bytes((43, 14))
    assert answer[3:6] == bytes((0x82, 0, 0))
    count, rest, objects = answer[6], answer[7:], {}
    for _ in range(count):
        objects[rest[0]] = rest[2 : 2 + rest[1]]
        rest = rest[2 + rest[1] :]
    assert rest == b""
    return objects


def test_device_identification_names_vendor_product_and_revision(wire):
    basic = identified(wire.ask(bytes((43, 14, 1, 0))))
    assert basic[0] == b"Hotgauge"
    assert sorted(basic) == [0, 1, 2]
    regular = identified(wire.ask(bytes((43, 14, 2, 0))))
    assert basic.items() < regular.items()
    assert regular[4] == b"Hotgauge bar gauge", "object 4 is the product's name, 5 that of its model"
    assert regular[5].startswith(b"register map ")
    assert identified(wire.ask(bytes((43, 14, 3, 0)))) == regular  # the level that it conforms to
    assert sorted(identified(wire.ask(bytes((43, 14, 2, 2))))) == [key for key in sorted(regular) if key >= 2]
    assert identified(wire.ask(bytes((43, 14, 2, 99)))) == regular  # an unknown object starts from the first
    assert identified(wire.ask(bytes((43, 14, 4, 1)))) == {1: regular[1]}


def test_device_identification_refuses_what_it_does_not_have(wire):
    assert wire.ask(bytes((43, 14, 4, 3))) == exception(43, 2)
    assert wire.ask(bytes((43, 14, 4, 200))) == exception(43, 2)
    assert wire.ask(bytes((43, 14, 0, 0))) == exception(43, 3)
    assert wire.ask(bytes((43, 14, 5, 0))) == exception(43, 3)
    assert wire.ask(bytes((43, 14, 1))) == exception(43, 3)
    assert wire.ask(bytes((43, 14))) == exception(43, 3)
    assert wire.ask(bytes((43, 13, 0, 0))) == exception(43, 1)
    assert wire.ask(bytes((43,))) == exception(43, 1)


def test_random_requests_are_always_answered_once_and_in_form(wire):
    chance = random.Random(7)
    for _ in range(2000):
        function = chance.choice([*SERVED, chance.randrange(256)])
        request = bytes((function,)) + chance.randbytes(chance.choice([1, 4, 5, 7, 11, 60]))
        answer = wire.ask(request)
        assert answer[0] == function or (answer[0] == function | 0x80 and answer[1] in {1, 2, 3})
