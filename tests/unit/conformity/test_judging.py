"""Truth is exact arithmetic in fractions, and the published elongations of steel."""

import itertools
import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from messages import reading

from appliance.conformity.advisor import Advisor
from appliance.conformity.cold_size import Size, cold_size
from appliance.conformity.correction import wanted_correction_mm
from appliance.conformity.decision import allowed_uncertainty_mm, decide
from appliance.conformity.set_points import SetPoints
from appliance.conformity.settings import CorrectionSettings, JudgingSettings
from appliance.conformity.thermal_expansion import GRADES
from appliance.sizing.set_points import STEELS, SetPointSettings
from appliance.sizing.trust import trust_percent
from plc.codes import Decision
from vision.reasons import Reason

CARBON, AUSTENITIC = 1, 2
sixty_fourths = st.integers(1, 64 * 20).map(lambda n: n / 64)  # exact in binary


@pytest.mark.parametrize(
    ("grade", "temperature_c", "percent", "within"),
    [
        (CARBON, 1050, 1.48, 0.005),
        (CARBON, 1100, 1.58, 0.005),
        (CARBON, 20, 0.0, 0.001),
        (CARBON, 500, 0.68, 0.02),
        (AUSTENITIC, 1100, 2.1, 0.05),
        (AUSTENITIC, 1250, 2.5, 0.05),
        (AUSTENITIC, 20, 0.0, 0.001),
    ],
)
def test_elongations_are_the_published_ones(grade, temperature_c, percent, within):
    assert 100 * GRADES[grade].elongation(temperature_c) == pytest.approx(percent, abs=within)


@pytest.mark.parametrize("grade", GRADES)
def test_hotter_steel_is_never_smaller_and_the_curve_has_no_jump(grade):
    sizes = [GRADES[grade].elongation(temperature_c) for temperature_c in range(20, 1401)]
    steps = [b - a for a, b in itertools.pairwise(sizes)]
    assert min(steps) >= 0
    assert max(steps) < 4e-5


def points(**changes: float | int | None) -> SetPoints:
    return SetPoints(**({"temperature_c": 1050.0, "grade": CARBON} | changes))


def test_the_cold_size_is_the_hot_one_without_its_elongation():
    cold = cold_size(Size(254.0, 0.2), points(), 0.0)
    assert cold.diameter_mm == pytest.approx(254.0 / 1.0148, abs=1e-3)
    assert cold.expanded_mm == pytest.approx(0.2 / 1.0148, abs=1e-4)


def test_the_doubt_about_the_temperature_widens_the_cold_uncertainty():
    # 25 °C at 2e-5 per °C on 250 mm, k = 2: 0.25 mm, beside 0.2 mm of the gauge
    cold = cold_size(Size(250.0, 0.2), points(), 25.0)
    assert cold.expanded_mm == pytest.approx(math.hypot(0.2, 2 * 25 * 2e-5 * 250) / 1.0148, rel=0.02)


@pytest.mark.parametrize("missing", [{"temperature_c": None}, {"grade": None}, {"grade": 77}])
def test_without_temperature_or_a_known_grade_there_is_no_cold_size(missing):
    assert cold_size(Size(250.0, 0.2), points(**missing), 25.0) is None


@given(sixty_fourths, sixty_fourths, sixty_fourths, st.sampled_from([-1, 0, 1]))
def test_the_decision_changes_exactly_at_the_four_edges_of_the_guard_bands(plus, minus, expanded, side):
    step = side / 64
    for edge, towards_the_middle in ((plus, -1), (-minus, 1)):
        for band, outcome in ((expanded, Decision.IN), (-expanded, Decision.OUT)):
            deviation = edge + towards_the_middle * (band + step)
            assert decide(deviation, expanded, (plus, minus)) == exact(deviation, expanded, plus, minus)
            wide_enough = expanded * 2 + 2 / 64 <= plus + minus
            if wide_enough and side == 0:
                assert decide(deviation, expanded, (plus, minus)) == outcome
            if wide_enough and side == (-1 if outcome == Decision.IN else 1):
                assert decide(deviation, expanded, (plus, minus)) == Decision.UNDECIDED


def exact(deviation: float, expanded: float, plus: float, minus: float) -> Decision:
    """By the sentence of the rule: 1 in (inside by at least g), 2 out (outside by at least g), 3 undecided."""
    d, g, upper, lower = Fraction(deviation), Fraction(expanded), Fraction(plus), -Fraction(minus)
    if lower + g <= d <= upper - g:
        return Decision.IN
    if d >= upper + g or d <= lower - g:
        return Decision.OUT
    return Decision.UNDECIDED


@given(st.integers(0, 30), st.integers(1, 30), sixty_fourths, st.none() | st.tuples(sixty_fourths, sixty_fourths))
def test_trust_is_the_formula(kept, total, expanded, tolerance):
    kept = min(kept, total)
    set_points = SetPoints() if tolerance is None else SetPoints(None, *tolerance)
    u_max = Fraction(1, 4) if tolerance is None else (Fraction(tolerance[0]) + Fraction(tolerance[1])) / 8
    truth = 100 * Fraction(kept, total) * min(Fraction(1), u_max / Fraction(expanded))
    reading = thick(windows_kept=kept, windows_total=total, expanded_uncertainty_mm=expanded)
    trust = trust_percent(reading, allowed_uncertainty_mm(set_points))
    assert trust == pytest.approx(float(truth), rel=1e-12)
    assert 0 <= trust <= 100


def test_without_windows_there_is_no_trust():
    assert trust_percent(thick(windows_kept=0, windows_total=0)) == 0


def test_one_tolerance_alone_is_no_tolerance():
    assert SetPoints(tolerance_plus_mm=1.0).tolerance_mm is None
    assert allowed_uncertainty_mm(SetPoints(tolerance_minus_mm=1.0)) == 0.25


CORRECTION = CorrectionSettings(gain=0.5, dead_band_mm=0.25, rate_mm_per_s=0.5, limit_mm=1.0)


@pytest.mark.parametrize(
    ("deviation", "wanted"),
    [(0, 0), (0.25, 0), (-0.25, 0), (0.26, -0.13), (-1, 0.5), (1, -0.5), (2, -1), (2.5, -1), (-9, 1)],
)
def test_the_correction_opposes_the_deviation_outside_of_the_dead_band_within_the_clamp(deviation, wanted):
    assert wanted_correction_mm(deviation, CORRECTION) == pytest.approx(wanted)


class Advising(Advisor):
    """An advisor with its set points, and the values of a moment in one call."""

    points = SetPoints(target_mm=250.0)

    def values_at(self, reading, now_s: float) -> dict:
        self.update(reading, self.points, now_s)
        return self.values()


def advisor(**changes: float) -> Advising:
    made = Advising(JudgingSettings(), CORRECTION)
    made.points = SetPoints(**({"target_mm": 250.0} | changes))
    return made


def thick(diameter_mm: float = 254.0, **changes: object):
    """A bar that asks for the largest correction, -1 mm."""
    return reading(**({"diameter_mm": diameter_mm, "windows_kept": 25} | changes)).reading


def test_the_correction_grows_no_faster_than_its_rate_and_stays_at_its_clamp():
    advising = advisor()
    advising.values_at(None, 100.0)
    seen = [advising.values_at(thick(), 100.0 + n / 10)["correction"] for n in range(1, 31)]
    assert seen[:4] == pytest.approx([-0.05, -0.1, -0.15, -0.2])
    assert seen[-1] == -1.0
    assert all(0 <= before - after <= 0.05 + 1e-9 for before, after in itertools.pairwise(seen))


def test_the_first_reading_asks_for_no_correction():
    assert advisor().values_at(thick(), 1e6)["correction"] == 0


@pytest.mark.parametrize(
    "untrusted", [None, thick(reasons=Reason.FIT_FAILED), thick(expanded_uncertainty_mm=0.6), thick(windows_kept=12)]
)
def test_the_correction_is_zero_at_once_without_trust_and_begins_from_zero_again(untrusted):
    advising = advisor()
    for n in range(30):
        advising.values_at(thick(), 100.0 + n / 10)
    assert advising.values_at(untrusted, 103.0)["correction"] == 0
    assert advising.values_at(thick(), 103.1)["correction"] == pytest.approx(-0.05)


def test_without_a_target_there_is_no_correction_no_deviation_and_no_decision():
    values = advisor(target_mm=None, tolerance_plus_mm=1.0, tolerance_minus_mm=1.0).values_at(thick(), 100.0)
    assert values["correction"] is None
    assert "deviation" not in values
    assert values["decision"] == Decision.NONE


def test_a_target_without_tolerances_gives_a_deviation_and_no_decision():
    values = advisor().values_at(thick(), 100.0)
    assert values["deviation"] == 4.0
    assert values["decision"] == Decision.NONE


def test_with_a_grade_target_and_tolerances_are_cold():
    advising = advisor(temperature_c=1050.0, grade=CARBON, tolerance_plus_mm=1.0, tolerance_minus_mm=1.0)
    values = advising.values_at(thick(250 * 1.0148), 100.0)
    assert values["diameter_cold"] == pytest.approx(250.0, abs=1e-6)
    assert values["deviation"] == pytest.approx(0.0, abs=1e-6)
    assert values["decision"] == Decision.IN
    hot = advisor(temperature_c=1050.0, tolerance_plus_mm=1.0, tolerance_minus_mm=1.0).values_at(
        thick(250 * 1.0148), 1.0
    )
    assert hot["deviation"] == pytest.approx(3.7)
    assert hot["decision"] == Decision.OUT


def test_the_decision_with_a_grade_guards_with_the_cold_uncertainty():
    # hot U = 0.2 alone would say "in" at 0.3 mm inside; the temperature's 0.25 mm make it undecided
    advising = advisor(temperature_c=1050.0, grade=CARBON, tolerance_plus_mm=1.0, tolerance_minus_mm=1.0)
    assert advising.values_at(thick(250.7 * 1.0148), 100.0)["decision"] == Decision.UNDECIDED


def test_a_grade_without_temperature_gives_no_decision_rather_than_a_hot_one():
    values = advisor(grade=CARBON, tolerance_plus_mm=1.0, tolerance_minus_mm=1.0).values_at(thick(), 100.0)
    assert "deviation" not in values
    assert values["decision"] == Decision.NONE


def test_trust_follows_the_tolerance_of_the_set_points():
    advising = advisor()
    assert advising.values_at(thick(expanded_uncertainty_mm=0.5), 1.0)["trust"] == pytest.approx(50)
    advising.points = SetPoints(tolerance_plus_mm=2.0, tolerance_minus_mm=2.0)
    assert advising.values_at(thick(expanded_uncertainty_mm=0.5), 1.0)["trust"] == pytest.approx(100)
    assert advising.values_at(thick(expanded_uncertainty_mm=0.5, reasons=Reason.ROUTES_DISAGREE), 1.0)["trust"] == 50
    assert advising.values_at(thick(reasons=Reason.FIT_FAILED), 1.0)["trust"] == 0
    assert "trust" not in advising.values_at(None, 1.0)


@pytest.mark.parametrize(
    ("changes", "low"),
    [
        ({"expanded_uncertainty_mm": 0.51}, True),
        ({"expanded_uncertainty_mm": 0.5}, False),
        ({"reasons": Reason.FIT_FAILED}, True),
        ({"reasons": Reason.NO_BAR}, False),
    ],
)
def test_trust_is_low_only_while_a_bar_is_there(changes, low):
    advising = advisor()
    advising.update(thick(**changes), advising.points, 1.0)
    assert advising.low_trust is low


def test_without_a_reading_trust_is_not_low():
    advising = advisor()
    advising.update(None, advising.points, 1.0)
    assert not advising.low_trust


def test_what_the_plc_has_set_counts_more_than_the_settings_one_by_one():
    settings = SetPointSettings(target_mm=250.0, tolerance_plus_mm=0.4, grade="1.4301", temperature_c=1050.0)
    settings = SetPoints.from_settings(settings)
    plc = SetPoints.from_words({"target_diameter": 26550, "steel_temperature": 1100, "expansion_grade": 0})
    together = plc.over(settings)
    assert (together.target_mm, together.temperature_c) == (265.5, 1100.0)
    assert (together.tolerance_plus_mm, together.tolerance_minus_mm, together.grade) == (0.4, None, AUSTENITIC)
    assert SetPoints.from_words({}).over(settings) == settings


@pytest.mark.parametrize(
    ("name", "grade"),
    [
        ("40CrMo4", CARBON),
        ("42crmo4", CARBON),
        ("1.7225", CARBON),
        ("aisi304l", AUSTENITIC),
        ("X5CrNi18-10", AUSTENITIC),
    ],
)
def test_a_steel_is_known_by_its_name_or_number(name, grade):
    assert SetPoints.from_settings(SetPointSettings(grade=name)).grade == grade


def test_an_unknown_steel_is_named_with_the_nearest():
    with pytest.raises(ValueError, match="did you mean 42CrMo4"):
        SetPointSettings(grade="42CrMo5")


def test_every_steel_has_a_row_of_the_expansion_table():
    assert set(STEELS.values()) == set(GRADES)


@pytest.mark.parametrize("doubt", [{"windows_kept": 1}, {"expanded_uncertainty_mm": 0.6}])
def test_a_diameter_that_cannot_be_trusted_is_undecided_however_clear_its_deviation(doubt):
    advising = advisor(tolerance_plus_mm=1.0, tolerance_minus_mm=1.0)
    assert advising.values_at(thick(254.0), 100.0)["decision"] == Decision.OUT
    assert advising.values_at(thick(254.0, **doubt), 100.1)["decision"] == Decision.UNDECIDED
    assert advising.values_at(thick(250.0, **doubt), 100.2)["decision"] == Decision.UNDECIDED
    assert advising.decision is Decision.UNDECIDED
