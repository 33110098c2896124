"""What is published of an ingot's verdicts and decisions, and its ring."""

import pytest
from messages import ingot_message, verdict

from appliance.ingot.published import GONE_PICTURES, IngotPublication
from plc.process_image import VALUE_NAMES, decode, encode
from plc.registers import INGOT_RING
from vision.reasons import IngotReason

NOW_S = 100.25


class Served(IngotPublication):
    """A publication with the values of a moment in one call."""

    held = False

    def values_at(self, now_s):
        self.update(now_s, held=self.held)
        return self.values()

    def wrong_orientation_at(self, now_s):
        self.update(now_s, held=self.held)
        return self.wrong_orientation


@pytest.fixture
def served():
    return Served(stale_after_ms=2000)


def block(values, name="measurement"):
    image = encode(values)
    data = image.words if name == "measurement" else image.ingot_ring
    return decode([int.from_bytes(data[place : place + 2]) for place in range(0, len(data), 2)], block=name)


def test_every_name_that_is_published_is_in_the_register_map(served):
    served.add(ingot_message(current=verdict(), told=(verdict(),)))
    assert served.values_at(NOW_S).keys() <= VALUE_NAMES


def test_without_a_station_there_is_no_value(served):
    seen = block(served.values_at(NOW_S))
    assert (seen["ingot_orientation"], seen["ingot_validity"], seen["ingot_sequence"]) == (0, 0, 0)
    assert seen["ingot_reason_word"] == IngotReason.STARTING
    assert seen["ssim_top"] is seen["ingot_confidence"] is seen["ingot_age"] is None


def test_a_decided_ingot_is_served_whole(served):
    served.add(ingot_message(current=verdict(ingot=3)))
    seen = block(served.values_at(NOW_S))
    assert (seen["ingot_orientation"], seen["ingot_validity"], seen["ingot_sequence"]) == (1, 1, 3)
    assert seen["ingot_confidence"] == pytest.approx(99.5)
    assert (seen["ssim_top"], seen["ssim_bottom"]) == pytest.approx((0.81, 0.69))
    assert seen["ingot_age"] == 250


def test_an_undecided_ingot_is_not_valid_and_reasons_make_validity_two(served):
    served.add(ingot_message(current=verdict(orientation="undecided", confidence=70.0)))
    seen = block(served.values_at(NOW_S))
    assert (seen["ingot_orientation"], seen["ingot_validity"]) == (3, 0)
    served.add(ingot_message(current=verdict(orientation="bottom"), reasons=IngotReason.GLARE_JOINED))
    seen = block(served.values_at(NOW_S))
    assert (seen["ingot_orientation"], seen["ingot_validity"]) == (2, 2)


def test_only_an_ingot_that_is_decided_to_show_its_top_is_a_wrong_orientation(served):
    assert not served.wrong_orientation_at(NOW_S)
    for orientation, wrong in (
        ("bottom", False),
        ("undecided", False),
        ("top", True),
        ("undecided", True),
        ("bottom", False),
    ):
        served.add(ingot_message(current=verdict(orientation=orientation)))
        assert served.wrong_orientation_at(NOW_S) is wrong


def test_a_top_is_a_wrong_orientation_until_the_line_is_seen_empty_or_with_a_bottom(served):
    served.add(ingot_message(current=verdict()))
    assert served.wrong_orientation_at(NOW_S + 3)  # stale: nobody knows that it has gone
    served.withdraw(IngotReason.NO_PICTURE, restarted=False)
    assert served.wrong_orientation_at(NOW_S)
    served.withdraw(IngotReason.STARTING, restarted=True)
    served.add(ingot_message(present=False))
    assert served.wrong_orientation_at(NOW_S)  # one picture may miss an end
    for _ in range(GONE_PICTURES):
        served.add(ingot_message(present=False))
    assert not served.wrong_orientation_at(NOW_S)


def test_a_top_is_gone_after_so_many_empty_pictures_in_a_row_and_not_before(served):
    served.add(ingot_message(current=verdict()))
    for _ in range(GONE_PICTURES - 1):
        served.add(ingot_message(present=False))
    served.add(ingot_message(present=True))
    for _ in range(GONE_PICTURES - 1):
        served.add(ingot_message(present=False))
    assert served.wrong_orientation_at(NOW_S)
    served.add(ingot_message(present=False))
    assert not served.wrong_orientation_at(NOW_S)


def test_nothing_stands_when_stale_held_or_withdrawn(served):
    served.add(ingot_message(current=verdict()))
    for now_s, held in ((NOW_S + 3, False), (NOW_S, True)):
        served.held = held
        seen = block(served.values_at(now_s))
        assert (seen["ingot_orientation"], seen["ingot_validity"], seen["ssim_top"]) == (0, 0, None)
        assert seen["ingot_reason_word"]
    served.held = False
    served.withdraw(IngotReason.NO_PICTURE, restarted=False)
    seen = block(served.values_at(NOW_S))
    assert (seen["ingot_orientation"], seen["ingot_reason_word"], seen["ingot_age"]) == (
        0,
        IngotReason.NO_PICTURE,
        None,
    )


def test_the_ring_holds_the_last_eight_ingots_once_each(served):
    told = []
    for number in range(1, 11):
        told.append(verdict(ingot=number, orientation=("top", "bottom", "undecided")[number % 3]))
        served.add(ingot_message(told=tuple(told[-4:])))
        served.add(ingot_message(told=tuple(told[-4:])))  # told again, in case a message was lost
    seen = block(served.values_at(NOW_S), "ingot_ring")
    assert seen["ingot_ring_index"] == 10
    assert [seen[f"ingot_{slot}_sequence"] for slot in range(8)] == [9, 10, 3, 4, 5, 6, 7, 8]
    assert (seen["ingot_1_orientation"], seen["ingot_1_validity"]) == (2, 1)
    assert (seen["ingot_6_orientation"], seen["ingot_6_validity"]) == (2, 1)
    assert (seen["ingot_7_orientation"], seen["ingot_7_validity"]) == (3, 0)
    assert seen["ingot_0_timestamp"] == 1_700_000_000_000
    assert len(INGOT_RING) == 100


def test_a_station_that_starts_again_goes_on_counting(served):
    served.add(ingot_message(current=verdict(ingot=2), told=(verdict(ingot=1), verdict(ingot=2))))
    served.withdraw(IngotReason.STARTING, restarted=True)
    served.add(ingot_message(current=verdict(ingot=1), told=(verdict(ingot=1),)))
    values = served.values_at(NOW_S)
    assert (values["ingot_sequence"], values["ingot_ring_index"]) == (3, 3)
