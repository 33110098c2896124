"""What outlasts one reading: the ring of the last eight, statistics per bar, reasons that last."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from messages import reading

from appliance.conformity.bar_statistics import BarStatistics, part_of_bar
from appliance.sizing.lasting_reasons import LastingReasons
from appliance.sizing.reading_ring import ReadingRing
from plc.process_image import VALUE_NAMES, decode, encode
from vision.reasons import Reason


def ring_words(ring: ReadingRing) -> dict:
    words = encode(ring.values()).reading_ring
    return decode([int.from_bytes(words[n : n + 2]) for n in range(0, len(words), 2)], block="reading_ring")


def measured(number: int) -> dict:
    return {"sequence": number, "validity": 1, "diameter": 200.0 + number, "trust": 80.0, "timestamp": 10**12 + number}


@given(st.integers(0, 40))
def test_the_last_eight_readings_stand_behind_the_index(count):
    ring = ReadingRing()
    for number in range(count):
        ring.add(measured(number))
    shown = ring_words(ring)
    assert shown["reading_ring_index"] == count
    for back in range(1, min(count, 8) + 1):
        slot = (count - back) % 8
        assert shown[f"reading_{slot}_sequence"] == count - back
        assert shown[f"reading_{slot}_diameter"] == 200 + count - back
        assert shown[f"reading_{slot}_diameter_u16"] == 200 + count - back
        assert shown[f"reading_{slot}_timestamp"] == 10**12 + count - back


@given(st.lists(st.integers(1, 8), max_size=30))
def test_a_plc_that_looks_at_least_every_eight_readings_loses_none(steps):
    ring, seen, number, known = ReadingRing(), [], 0, 0
    for step in steps:
        for _ in range(step):
            ring.add(measured(number))
            number += 1
        shown = ring_words(ring)
        index = shown["reading_ring_index"]
        seen += [shown[f"reading_{n % 8}_sequence"] for n in range(known, index)]
        known = index
    assert seen == list(range(number))


def test_a_reading_without_value_takes_a_slot_and_leaves_nothing_of_the_one_before():
    ring = ReadingRing()
    for number in range(9):
        ring.add(measured(number) if number < 8 else {"sequence": 8, "validity": 0})
    shown = ring_words(ring)
    assert shown["reading_0_validity"] == 0
    for field in ("diameter", "diameter_u16", "expanded_uncertainty", "trust", "timestamp"):
        assert shown[f"reading_0_{field}"] is None


def test_the_index_wraps_as_a_word_does_and_slots_go_on_in_order():
    ring = ReadingRing()
    for number in range(0x10000 + 3):
        ring.add(measured(number & 0xFFFF))
    shown = ring_words(ring)
    assert shown["reading_ring_index"] == 3
    assert shown["reading_2_sequence"] == 2


GAP_S = 0.3


@pytest.fixture
def bars() -> BarStatistics:
    return BarStatistics(GAP_S)


def take(bars: BarStatistics, at_s: float, diameter_mm: float | None, reasons: int = 0) -> dict:
    measured_mm = math.nan if diameter_mm is None else diameter_mm
    bars.add(reading(exposed_monotonic_s=at_s, diameter_mm=measured_mm, reasons=Reason(reasons)))
    return bars.values()


NO_BAR = Reason.NO_BAR


def test_names_are_those_of_the_map_and_before_the_first_bar_there_is_no_value(bars):
    assert bars.values().keys() | ReadingRing().values().keys() <= VALUE_NAMES
    words = encode(bars.values()).words
    shown = decode([int.from_bytes(words[n : n + 2]) for n in range(0, len(words), 2)])
    assert [shown[name] for name in ("bar_sequence", "bar_min", "bar_mean", "bar_max")] == [0, None, None, None]


@given(st.lists(st.floats(80, 300), min_size=1, max_size=50))
def test_a_bar_is_told_by_its_smallest_mean_and_largest_diameter(diameters):
    bars = BarStatistics(GAP_S)
    for number, diameter in enumerate(diameters):
        values = take(bars, number / 10, diameter)
    assert values["bar_sequence"] == 1
    assert values["bar_min"] == min(diameters)
    assert values["bar_max"] == max(diameters)
    assert values["bar_mean"] == pytest.approx(sum(diameters) / len(diameters))


def test_a_gap_parts_two_bars_and_the_first_stands_until_the_second_begins(bars):
    take(bars, 0.0, 200.0)
    for tick in range(1, 8):
        assert take(bars, tick / 10, None, NO_BAR)["bar_max"] == 200.0
    values = take(bars, 0.8, 100.0)
    assert (values["bar_sequence"], values["bar_max"]) == (2, 100.0)


def test_a_miss_that_is_shorter_than_a_gap_parts_nothing(bars):
    take(bars, 0.0, 200.0)
    take(bars, 0.1, None, NO_BAR)
    take(bars, 0.2, None, NO_BAR)
    assert take(bars, 0.35, 201.0)["bar_sequence"] == 1


def test_a_bar_that_is_seen_but_not_measured_goes_on(bars):
    take(bars, 0.0, 200.0)
    for tick in range(1, 20):
        take(bars, tick / 10, None, int(Reason.EDGE_NOT_FOUND))
    assert take(bars, 2.0, 201.0)["bar_sequence"] == 1


@pytest.mark.parametrize(("blind_s", "bars_seen"), [(1.9, 1), (2.1, 2)])
def test_a_computer_that_is_late_parts_nothing_and_a_long_blindness_does(bars, blind_s, bars_seen):
    take(bars, 0.0, 200.0)
    assert take(bars, blind_s, 201.0)["bar_sequence"] == bars_seen


def test_time_that_runs_back_parts_two_bars(bars):
    take(bars, 5.0, 200.0)
    assert take(bars, 1.0, 200.0)["bar_sequence"] == 2


def test_after_blindness_the_next_bar_is_another_one(bars):
    take(bars, 0.0, 200.0)
    bars.end()
    assert take(bars, 0.1, 200.0)["bar_sequence"] == 2


HEAD, TAIL, SHORT = Reason.BAR_HEAD, Reason.BAR_TAIL, Reason.BAR_TOO_SHORT


def test_a_bar_is_seen_in_parts_one_after_the_other():
    passing = [NO_BAR, SHORT | HEAD, HEAD, Reason.NONE, TAIL, TAIL | SHORT, NO_BAR]
    assert [part_of_bar(reasons).value for reasons in passing] == [
        *("none", "enter", "head", "body", "tail", "leave", "none"),
    ]


def test_the_body_alone_counts_as_soon_as_there_is_one(bars):
    assert take(bars, 0.0, 190.0, HEAD)["bar_min"] == 190.0
    take(bars, 0.1, 200.0)
    take(bars, 0.2, 202.0)
    values = take(bars, 0.3, 180.0, TAIL)
    assert (values["bar_min"], values["bar_mean"], values["bar_max"]) == (200.0, 201.0, 202.0)
    assert values["bar_sequence"] == 1


def test_a_bar_shorter_than_the_region_is_told_by_its_ends(bars):
    take(bars, 0.0, 190.0, HEAD)
    assert take(bars, 0.1, 192.0, HEAD | TAIL)["bar_mean"] == 191.0


def active(lasting: LastingReasons, moments_s, reasons: Reason) -> set[str]:
    for at_s in moments_s:
        lasting.add(reading(exposed_monotonic_s=at_s, reasons=reasons))
    return {fault for fault, there in lasting.faults().items() if there}


def every_tenth(first_s: float, last_s: float) -> list[float]:
    return [tick / 10 for tick in range(round(10 * first_s), round(10 * last_s) + 1)]


@pytest.mark.parametrize(
    ("reason", "fault"),
    [
        (Reason.LOW_CONTRAST, "contrast_low"),
        (Reason.CALIBRATION_DUE, "calibration_due"),
        (Reason.CAMERA_MOVED, "calibration_due"),
    ],
)
def test_a_doubt_becomes_a_fault_when_it_lasts_and_ends_when_it_is_long_gone(reason, fault):
    lasting = LastingReasons(10.0)
    assert not active(lasting, every_tenth(0.0, 9.9), reason)
    assert active(lasting, [10.1], reason) == {fault}
    assert active(lasting, every_tenth(10.2, 20.0), Reason.NONE) == {fault}
    assert not active(lasting, [20.2], Reason.NONE)


@pytest.mark.parametrize(("of_five", "is_fault"), [(2, False), (4, True)])
def test_a_doubt_in_most_readings_is_a_fault_and_in_few_it_is_none(of_five, is_fault):
    lasting = LastingReasons(10.0)
    for tick in range(600):
        active(lasting, [tick / 10], Reason.LOW_CONTRAST if tick % 5 < of_five else Reason.NONE)
    assert bool(active(lasting, [], Reason.NONE)) is is_fault


def test_an_empty_line_between_two_doubtful_bars_does_not_count_as_lasting():
    lasting = LastingReasons(10.0)
    assert not active(lasting, [0.0], Reason.LOW_CONTRAST)
    assert not active(lasting, every_tenth(0.1, 60.0), Reason.NO_BAR)
    assert not active(lasting, [60.1], Reason.LOW_CONTRAST)
