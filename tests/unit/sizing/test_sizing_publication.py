"""What is published of a size reading, and what of a station that has none."""

import pytest
from messages import reading

from appliance.sizing.published import LARGEST_AGE_MS, Publication
from plc.process_image import VALUE_NAMES, decode, encode
from vision.reasons import Reason

STALE_AFTER_MS = 800
MEASUREMENTS = ("diameter", "expanded_uncertainty", "windows_kept", "windows_total")


class Served(Publication):
    """A publication with the values of a moment in one call."""

    held = False

    def values_at(self, now_s: float) -> dict:
        self.update(now_s, held=self.held)
        return self.values()


@pytest.fixture
def served() -> Served:
    return Served(STALE_AFTER_MS)


def words(values):
    return decode([int.from_bytes(pair) for pair in _pairs(encode(values).words)])


def _pairs(data):
    return [data[i : i + 2] for i in range(0, len(data), 2)]


def test_without_any_reading_there_is_no_value_and_the_reason_is_starting(served):
    values = served.values_at(100.0)
    assert values["validity"] == 0
    assert values["reason_word"] == Reason.STARTING
    shown = words(values)
    for name in (*MEASUREMENTS, "diameter_u16", "measurement_age", "timestamp"):
        assert shown[name] is None


def test_every_name_that_is_published_is_in_the_register_map(served):
    served.add(reading())
    assert served.values_at(100.1).keys() <= VALUE_NAMES


def test_a_fresh_reading_is_served_whole(served):
    served.add(reading(exposed_monotonic_s=100.0))
    shown = words(served.values_at(100.25))
    assert shown["diameter"] == 250.25
    assert shown["diameter_u16"] == 250.25
    assert shown["measurement_age"] == 250
    assert shown["timestamp"] == 1_700_000_000_000
    assert shown["validity"] == 1
    assert shown["sequence"] == shown["sequence_check"]


def test_reasons_that_do_not_forbid_a_value_make_validity_two(served):
    served.add(reading(reasons=Reason.LOW_CONTRAST))
    values = served.values_at(100.0)
    assert values["validity"] == 2
    assert values["diameter"] == 250.25


def test_a_reading_that_is_not_valid_has_no_diameter_even_if_it_carries_one(served):
    served.add(reading(reasons=Reason.VIEWS_DISAGREE))
    shown = words(served.values_at(100.0))
    assert shown["validity"] == 0
    assert shown["diameter"] is None
    assert shown["expanded_uncertainty"] is None


def test_no_bar_is_no_value_and_no_bar_present(served):
    served.add(reading(reasons=Reason.NO_BAR))
    values = served.values_at(100.0)
    assert values["bar_present"] is False
    assert values["measurement_valid"] is False


@pytest.mark.parametrize(("age_ms", "stands"), [(STALE_AFTER_MS - 1, True), (STALE_AFTER_MS + 1, False)])
def test_a_reading_stands_until_it_is_stale(served, age_ms, stands):
    served.add(reading(exposed_monotonic_s=100.0))
    now_s = 100.0 + age_ms / 1000
    values = served.values_at(now_s)
    assert served.stale is not stands
    assert (values["validity"] == 1) is stands
    assert bool(values["reason_word"] & Reason.STALE) is not stands
    assert (values.get("diameter") is not None) is stands
    assert (words(values)["windows_kept"] is not None) is stands
    assert values["measurement_age"] == age_ms


def test_the_age_saturates_below_the_number_that_means_no_value(served):
    served.add(reading(exposed_monotonic_s=100.0))
    assert words(served.values_at(1000.0))["measurement_age"] == LARGEST_AGE_MS


def test_an_exposure_in_the_future_is_not_younger_than_now(served):
    served.add(reading(exposed_monotonic_s=100.0))
    assert served.values_at(99.9)["measurement_age"] == 0


def test_a_withdrawn_reading_leaves_nothing_standing(served):
    served.add(reading())
    served.withdraw(Reason.NO_PAIR)
    shown = words(served.values_at(100.0))
    assert shown["reason_word"] == Reason.NO_PAIR
    for name in (*MEASUREMENTS, "measurement_age", "timestamp", "cycle_time"):
        assert shown[name] is None


def sequences(served, *moments_s):
    return [served.values_at(moment_s)["sequence"] for moment_s in moments_s]


def test_the_sequence_rests_while_nothing_is_new(served):
    served.add(reading())
    first, *rest = sequences(served, 100.0, 100.05, 100.1)
    assert rest == [first, first]


def test_the_sequence_moves_by_one_with_each_reading_even_an_equal_one(served):
    served.add(reading())
    (first,) = sequences(served, 100.0)
    served.add(reading(sequence=1))
    assert sequences(served, 100.0) == [first + 1]


def test_the_sequence_moves_by_one_when_a_reading_becomes_stale_and_when_it_is_withdrawn(served):
    served.add(reading())
    (first,) = sequences(served, 100.0)
    assert sequences(served, 101.0, 102.0) == [first + 1, first + 1]
    served.withdraw(Reason.STARTING)
    assert sequences(served, 103.0) == [first + 2]


def test_the_sequence_counts_readings_and_wraps_within_sixteen_bits(served):
    served._sequence = 0xFFF0  # as after 65,520 readings
    seen = []
    for number in range(0x20):
        served.add(reading().model_copy(update={"sequence": number}))
        seen.append(served.values_at(100.0)["sequence"])
    assert seen == [*range(0xFFF1, 0x10000), *range(0x11)]


def test_dropped_pairs_are_counted_on_when_the_measuring_process_starts_again(served):
    served.add(reading(dropped=5))
    served.withdraw(Reason.NO_PAIR)
    served.add(reading(dropped=7))
    served.withdraw(Reason.STARTING)
    served.add(reading(dropped=2))
    assert served.values_at(100.0)["frames_dropped"] == 9


def test_the_cycle_time_is_the_time_between_two_exposures(served):
    served.add(reading(exposed_monotonic_s=100.0))
    assert served.values_at(100.0)["cycle_time"] is None
    served.add(reading(exposed_monotonic_s=100.2))
    assert served.values_at(100.2)["cycle_time"] == pytest.approx(200.0)


def test_a_held_gauge_serves_no_value_and_says_why(served):
    served.add(reading())
    served.held = True
    values = served.values_at(100.0)
    shown = words(values)
    assert shown["validity"] == 0
    assert shown["reason_word"] == Reason.HELD
    assert "measurement_valid" not in values
    for name in MEASUREMENTS:
        assert shown[name] is None
    served.held = False
    assert served.values_at(100.0)["diameter"] == 250.25


def test_hold_and_its_end_each_move_the_sequence_by_one(served):
    served.add(reading())
    (first,) = sequences(served, 100.0)
    served.held = True
    assert sequences(served, 100.0, 100.1) == [first + 1, first + 1]
    served.held = False
    assert sequences(served, 100.2, 100.3) == [first + 2, first + 2]


def test_two_readings_between_two_swaps_have_a_number_each(served):
    (first,) = sequences(served, 100.0)
    served.add(reading())
    served.add(reading(sequence=1))
    assert sequences(served, 100.0) == [first + 2]


def test_a_new_process_that_has_already_dropped_more_than_the_old_one_is_counted_from_zero(served):
    served.add(reading(dropped=5))
    served.withdraw(Reason.STARTING)
    served.add(reading(dropped=8))
    assert served.values_at(100.0)["frames_dropped"] == 13
