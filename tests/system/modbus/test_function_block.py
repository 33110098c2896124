"""The function block that is printed for PLCs, run against a gauge by an interpreter."""

import math
import random
import struct

import pytest
from modbus_wire import LIVE, Wire, read, served
from structured_text_interpreter import Source, float32

from plc.process_image import encode
from plc.server import ModbusServer
from plc.structured_text.program import to_structured_text

CYCLE_S = 0.01


@pytest.fixture(scope="module")
def source() -> Source:
    return Source(to_structured_text())


class Plc:
    """A PLC whose Modbus block reads the words at each rising edge of `request`, and whose clock is ours."""

    def __init__(self, source: Source, wire: Wire, **inputs) -> None:
        self.block = source.block("HOTGAUGE")
        self.block.set(words=[0] * 120, **inputs)
        self.wire: Wire | None = wire
        self.now_s = 0.0
        self.requests = 0
        self._before = False

    def run(self, seconds: float) -> dict:
        until_s = self.now_s + seconds
        while self.now_s < until_s:
            self.now_s += CYCLE_S
            asked = self.block.values["request"] and not self._before
            self._before = self.block.values["request"]
            self.requests += asked
            answer = self._read() if asked else None
            if answer:
                self.block.set(words=answer)
            self.block.run(self.now_s, answered=bool(answer), failed=bool(asked and not answer))
        return dict(self.block.values)

    def _read(self) -> list[int] | None:
        if self.wire is None:
            return None
        return list(struct.unpack(">120H", self.wire.ask(read(4, 0, 120))[2:]))


class Gauge:
    """Publishes values whose heartbeat moves as long as it is told to."""

    def __init__(self, server: ModbusServer) -> None:
        self.server = server
        self.beat = 0

    def live(self, plc: Plc, seconds: float = 1.0, **values) -> dict:
        word_order = values.pop("word_order", "big")
        for _ in range(round(seconds / 0.1)):
            self.beat += 1
            self.server.publish(encode(LIVE | values | {"heartbeat": self.beat}, word_order=word_order))
            seen = plc.run(0.1)
        return seen


@pytest.fixture
def gauge():
    server = ModbusServer("127.0.0.1", 0)
    with served(server):
        yield Gauge(server)


@pytest.fixture
def plc(gauge, source):
    with Wire(gauge.server.port) as wire:
        yield Plc(source, wire)


GOOD = {"measurement_age": 80, "expanded_uncertainty": 0.21, "trust": 97.5, "decision": 1, "correction": 0.125}


def test_a_living_gauge_gives_its_values(gauge, plc):
    seen = gauge.live(plc, **GOOD)
    assert seen["usable"]
    assert seen["alive"]
    assert seen["diameter"] == pytest.approx(265.53, abs=1e-4)
    assert seen["expanded_uncertainty"] == float32(0.21)
    assert (seen["trust"], seen["correction"], seen["deviation"]) == (97.5, 0.125, -0.25)
    assert seen["has_deviation"]
    assert not seen["has_cold"]  # NaN is never converted
    assert seen["diameter_cold"] == 0
    assert not seen["alarm_dead"]
    assert 8 <= plc.requests <= 10


def test_nothing_is_usable_before_the_heartbeat_has_moved(gauge, plc):
    gauge.server.publish(encode(LIVE | GOOD))
    assert not plc.run(0.9)["usable"]
    assert gauge.live(plc, 0.5, **GOOD)["usable"]


def test_a_gauge_that_stands_still_is_dead_within_its_time_although_its_words_are_good(gauge, plc):
    assert gauge.live(plc, **GOOD)["usable"]
    seen = plc.run(1.2)
    assert not seen["usable"]
    assert seen["alarm_dead"]
    assert seen["device_state"] == 4
    assert seen["diameter"] == 0


def test_a_lost_connection_is_dead_too_and_comes_back(gauge, plc):
    wire = plc.wire
    assert gauge.live(plc, **GOOD)["usable"]
    plc.wire = None
    assert gauge.live(plc, 1.5, **GOOD)["alarm_dead"]
    plc.wire = wire
    assert gauge.live(plc, **GOOD)["usable"]


@pytest.mark.parametrize(
    ("change", "alarm"),
    [
        ({"validity": 0}, True),
        ({"measurement_age": 1001}, True),
        ({"measurement_age": None}, True),
        ({"simulated": True}, True),
    ],
)
def test_what_is_invalid_old_or_simulated_is_not_usable(gauge, plc, change, alarm):
    seen = gauge.live(plc, **GOOD | change)
    assert not seen["usable"]
    assert seen["diameter"] == 0
    assert seen["alarm_no_value"] == alarm
    assert seen["alive"]


def test_simulated_values_are_usable_when_told(gauge, source):
    with Wire(gauge.server.port) as wire:
        seen = gauge.live(Plc(source, wire, allow_simulated=True), **GOOD, simulated=True)
    assert seen["simulated"]
    assert seen["usable"]


def test_the_word_order_is_found_out_and_swapped_when_told(gauge, plc, source):
    seen = gauge.live(plc, **GOOD, word_order="little")
    assert seen["order_wrong"]
    assert not seen["usable"]
    with Wire(gauge.server.port) as wire:
        seen = gauge.live(Plc(source, wire, word_swap=True), **GOOD, word_order="little")
    assert seen["diameter"] == pytest.approx(265.53, abs=1e-4)


def test_a_torn_block_is_not_usable(gauge, plc):
    assert gauge.live(plc, **GOOD)["usable"]
    plc.block.values["words"][119] += 1
    plc.block.run(plc.now_s, answered=False)
    assert not plc.block.values["usable"]


def test_every_alarm_bit_is_an_output(gauge, plc):
    names = [
        name for name in plc.block.values if name.startswith("alarm_") and name not in {"alarm_dead", "alarm_no_value"}
    ]
    for bit, name in enumerate(names):
        seen = gauge.live(plc, 0.3, **GOOD, alarm_word=1 << bit)
        assert [other for other in names if seen[other]] == [name]


def test_enable_off_stops_polling(gauge, plc):
    gauge.live(plc, **GOOD)
    before = plc.requests
    plc.block.set(enable=False)
    seen = gauge.live(plc, **GOOD)
    assert not seen["usable"]
    assert plc.requests == before


def test_words_become_the_same_number_as_ieee_754_says(source):
    chance = random.Random(22)
    numbers = [0.0, 1.0, -1.0, 265.53, 1e-30, -1e30, 123.456, 3.4e38, 1.5, 2**-126]
    numbers += [chance.uniform(-1000, 1000) for _ in range(200)]
    for number in numbers:
        high, low = struct.unpack(">HH", struct.pack(">f", number))
        assert source.call("HOTGAUGE_REAL", {"high": high, "low": low}) == float32(number)
    for number in (math.nan, math.inf, -math.inf):
        high, low = struct.unpack(">HH", struct.pack(">f", number))
        assert source.call("HOTGAUGE_REAL", {"high": high, "low": low}) == 0
