"""Bits in words, as `hotgauge poll` shows them."""

from plc.codes import NamedBit
from plc.poll import Snapshot, _ingot_lines, _set_bits

BITS = {"fault_word": (NamedBit(0, "first", "the first"), NamedBit(5, "sixth", "the sixth"))}


def snapshot(word):
    return Snapshot(values={"fault_word": word}, discretes={}, elapsed_ms=1.0)


def test_a_word_without_a_value_has_no_bit_on():
    assert _set_bits(snapshot(None), "fault_word", BITS) == []
    assert _set_bits(snapshot(0), "fault_word", BITS) == []


def test_bits_that_are_on_are_named_lowest_first():
    assert [one.name for one in _set_bits(snapshot(0b100001), "fault_word", BITS)] == ["first", "sixth"]


def test_an_ingot_without_a_confidence_has_none():
    (line,) = _ingot_lines({"ingot_orientation": 1, "ingot_sequence": 4, "ingot_confidence": None})
    assert line.split(maxsplit=1) == ["ingot", "4, top, 0.00 %"]
