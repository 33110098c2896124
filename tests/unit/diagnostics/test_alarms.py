"""The oracle is the state-transition table of ISA-18.2 (figure 4), written down here and walked beside the product."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from appliance.diagnostics.alarms import ALARMS, Alarms
from appliance.diagnostics.fault_table import FAULTS
from plc.registers import REGISTERS

NAMES = [
    "alarm_wrong_orientation",
    "alarm_out_of_tolerance",
    "alarm_low_trust",
    "alarm_camera",
    "alarm_stale",
    "alarm_calibration",
    "alarm_plc_silent",
    "alarm_internal",
]
CONDITIONS = {"wrong_orientation", "out_of_tolerance", "low_trust", "plc_silent"}
BIT = {row.name: 1 << row.address for row in REGISTERS if row.type == "bool"}

# ISA-18.2: states A normal, B unacknowledged, C acknowledged, D returned to normal unacknowledged
TRANSITIONS = {
    ("A", "occurs"): "B",
    ("B", "acknowledged"): "C",
    ("B", "clears"): "D",
    ("C", "clears"): "A",
    ("D", "occurs"): "B",
    ("D", "acknowledged"): "A",
}
ANNOUNCED = {"A": False, "B": True, "C": True, "D": True}


STEP_S = 0.25
HALF_MINUTE = round(30 / STEP_S)


class Oracle:
    """One alarm by the table above; the cause counts when it has lasted for its delay."""

    def __init__(self, on_delay: int, off_delay: int) -> None:
        self.state = "A"
        self.delays = {"occurs": on_delay, "clears": off_delay}
        self.lasted = 0
        self.step_number = 0
        self.came: list[int] = []

    def step(self, cause: bool) -> None:
        self.step_number += 1
        event = "occurs" if cause else "clears"
        if (self.state in "AD") != cause:  # the cause is as the state says
            self.lasted = 0
            return
        if self.lasted >= (HALF_MINUTE if event == "clears" and self.chatters() else self.delays[event]):
            self.came += [self.step_number] if cause else []
            self.go(event)
            self.lasted = 0
        else:
            self.lasted += 1

    def chatters(self) -> bool:
        return len(self.came) >= 3 and self.came[-1] - self.came[-3] <= HALF_MINUTE

    def go(self, event: str) -> None:
        self.state = TRANSITIONS.get((self.state, event), self.state)


def rows(name: str):
    return next(row for row in ALARMS if row.name == name)


def test_the_table_has_the_eight_alarms_of_the_register_map_in_the_order_of_their_coils():
    assert [row.name for row in ALARMS] == NAMES
    assert [BIT[row.name] for row in ALARMS] == [1 << n for n in range(8)]


def test_every_alarm_points_at_a_fault_that_exists_or_at_a_condition_and_says_what_to_do():
    for row in ALARMS:
        assert row.causes
        assert set(row.causes) <= {fault.name for fault in FAULTS} | CONDITIONS
        assert row.priority in {"low", "medium", "high"}
        assert row.text
        assert row.remedy
        assert 0 <= row.on_delay_s <= 5
        assert 0 <= row.off_delay_s <= 5


CAUSES = sorted({cause for row in ALARMS for cause in row.causes})


@given(
    st.lists(st.tuples(st.sets(st.sampled_from(CAUSES)), st.booleans()), max_size=60).map(
        lambda moments: [moment for moment in moments for _ in range(2)]
    )
)
def test_every_random_history_follows_the_transition_table(moments):
    alarms = Alarms()
    oracles = {row: Oracle(round(row.on_delay_s / STEP_S), round(row.off_delay_s / STEP_S)) for row in ALARMS}
    for number, (causes, acknowledge) in enumerate(moments):
        alarms.update(causes, 1000 + number * STEP_S, suppressed=False)
        for row, oracle in oracles.items():
            oracle.step(any(cause in causes for cause in row.causes))
        assert alarms.word == sum(BIT[row.name] for row, oracle in oracles.items() if ANNOUNCED[oracle.state])
        if acknowledge:
            alarms.acknowledge()
            for oracle in oracles.values():
                oracle.go("acknowledged")
            assert alarms.word == sum(BIT[row.name] for row, oracle in oracles.items() if ANNOUNCED[oracle.state])


def shown(alarms: Alarms, causes: set[str], now_s: float, *, suppressed: bool = False) -> int:
    alarms.update(causes, now_s, suppressed=suppressed)
    return alarms.word


def test_a_cause_that_is_shorter_than_the_on_delay_never_alarms():
    alarms, delay_s = Alarms(), rows("alarm_low_trust").on_delay_s
    for second in range(10):
        assert shown(alarms, {"low_trust"}, 3.0 * second) == 0
        assert shown(alarms, {"low_trust"}, 3.0 * second + 0.9 * delay_s) == 0
        assert shown(alarms, set(), 3.0 * second + 0.95 * delay_s) == 0


def test_a_cause_that_flickers_within_the_off_delay_is_one_alarm():
    alarms = Alarms()
    shown(alarms, {"camera_lost"}, 0.0)
    alarms.acknowledge()
    for tick in range(1, 40):
        assert shown(alarms, {"camera_lost"} if tick % 2 else set(), tick / 4) == BIT["alarm_camera"]
    assert shown(alarms, set(), 10.5) == BIT["alarm_camera"]
    assert shown(alarms, set(), 11.6) == 0  # acknowledged before, so its end is its end


@given(st.lists(st.tuples(st.sets(st.sampled_from(CAUSES)), st.booleans()), max_size=40))
def test_while_held_nothing_is_shown_and_nothing_comes(moments):
    alarms = Alarms()
    before = 0
    for number, (causes, held) in enumerate(moments):
        now = shown(alarms, causes, float(number), suppressed=held)
        assert not held or now == 0
        if held:
            after = shown(alarms, set(), number + 0.5)
            assert after & ~before == 0  # what is shown after the hold was there before it
            before = after
        else:
            before = now


def test_what_was_unacknowledged_before_a_hold_is_shown_again_after_it():
    alarms = Alarms()
    shown(alarms, {"station_restarting"}, 0.0)
    assert shown(alarms, set(), 5.0, suppressed=True) == 0
    assert shown(alarms, set(), 10.0, suppressed=True) == 0
    assert shown(alarms, set(), 11.0) == BIT["alarm_internal"]
    alarms.acknowledge()
    assert alarms.word == 0


@pytest.mark.parametrize(
    ("row", "cause"),
    [(row, cause) for row in ALARMS for cause in row.causes],
    ids=lambda part: getattr(part, "name", part),
)
def test_an_alarm_stays_until_it_is_acknowledged_and_over(row, cause):
    alarms = Alarms()
    shown(alarms, {cause}, 0.0)
    assert shown(alarms, {cause}, 10.0) == BIT[row.name]
    assert shown(alarms, set(), 20.0) == BIT[row.name]
    assert shown(alarms, set(), 30.0) == BIT[row.name]
    alarms.acknowledge()
    assert alarms.word == 0


@pytest.mark.parametrize("period_s", [1.5, 2.2, 3.0, 5.0, 9.0])
def test_a_camera_that_comes_and_goes_is_shown_anew_at_most_three_times_in_half_a_minute(period_s):
    """Three faults take turns and somebody acknowledges at once, as at a mill that changes pace around a limit."""
    alarms, before, shown_s = Alarms(), 0, []
    faults = ["camera_lost", "camera_frozen", "pair_out_of_step"]
    for tick in range(6000):
        now_s = tick * 0.05
        turn, phase = divmod(now_s, period_s)
        causes = {faults[int(turn) % 3]} if phase < 0.3 else set()
        word = shown(alarms, causes, now_s)
        shown_s += [now_s] if word and not before else []
        alarms.acknowledge()
        before = alarms.word
    assert shown_s
    assert all(later - earlier > 30 for earlier, later in zip(shown_s, shown_s[3:], strict=False))


def test_an_alarm_that_has_calmed_down_ends_and_comes_as_before():
    alarms = Alarms()
    for second in (0, 4, 8):
        assert shown(alarms, {"camera_lost"}, second)
        alarms.acknowledge()
        shown(alarms, set(), second + 1)
        shown(alarms, set(), second + 3)
    assert shown(alarms, set(), 38.9) == BIT["alarm_camera"]
    assert shown(alarms, set(), 39.1) == 0
    assert shown(alarms, {"camera_lost"}, 60.0) == BIT["alarm_camera"]
    alarms.acknowledge()
    shown(alarms, set(), 61.0)
    assert shown(alarms, set(), 62.1) == 0


def test_a_shelved_alarm_is_not_shown_until_its_end_and_then_at_once_if_it_is_there():
    alarms = Alarms()
    shown(alarms, {"camera_lost"}, 0.0)
    alarms.shelve("alarm_camera", 100.0)
    assert shown(alarms, {"camera_lost", "plc_silent"}, 50.0) == BIT["alarm_plc_silent"]
    assert alarms.shelved_word == BIT["alarm_camera"]
    assert shown(alarms, {"camera_lost"}, 100.0) & BIT["alarm_camera"]
    assert alarms.shelved_word == 0


def test_a_shelved_alarm_can_be_taken_back_and_an_unknown_one_is_named():
    alarms = Alarms()
    shown(alarms, {"camera_lost"}, 0.0)
    alarms.shelve("alarm_camera", 100.0)
    alarms.shelve("alarm_camera", -math.inf)
    assert shown(alarms, {"camera_lost"}, 1.0) == BIT["alarm_camera"]
    with pytest.raises(ValueError, match="alarm_x"):
        alarms.shelve("alarm_x", 1.0)


def test_while_held_nobody_acknowledges_what_nobody_sees():
    alarms = Alarms()
    shown(alarms, {"camera_lost"}, 0.0)
    assert shown(alarms, set(), 5.0, suppressed=True) == 0
    alarms.acknowledge()
    assert shown(alarms, set(), 10.0) == BIT["alarm_camera"]
    alarms.acknowledge()
    assert alarms.word == 0


@pytest.mark.parametrize("step_s", [0.05, 0.25])
def test_a_cause_that_flips_in_the_step_after_a_transition_waits_its_whole_delay_anew(step_s):
    row, alarms, now_s = rows("alarm_low_trust"), Alarms(), 0.0
    while not shown(alarms, {"low_trust"}, now_s):
        now_s += step_s
    alarms.acknowledge()
    gone_s = now_s + step_s
    assert shown(alarms, set(), gone_s) == BIT[row.name]
    assert shown(alarms, set(), gone_s + row.off_delay_s - 0.01) == BIT[row.name]
    assert shown(alarms, set(), gone_s + row.off_delay_s + 0.01) == 0
    again_s = gone_s + row.off_delay_s + 0.02
    assert shown(alarms, {"low_trust"}, again_s) == 0
    assert shown(alarms, {"low_trust"}, again_s + row.on_delay_s - 0.01) == 0
    assert shown(alarms, {"low_trust"}, again_s + row.on_delay_s + 0.01) == BIT[row.name]
