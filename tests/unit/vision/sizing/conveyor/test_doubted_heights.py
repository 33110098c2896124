"""What one camera can check of itself: the barriers' faces against the heights, and the bar's width along the line."""

from dataclasses import replace

import numpy as np
import pytest

from appliance.simulation.foreign_thermal_line import random_foreign_thermal_line
from appliance.simulation.thermal_line import random_thermal_line
from vision.reasons import Reason
from vision.sizing.conveyor import scale
from vision.sizing.conveyor.beside_rollers import rollers_show
from vision.sizing.conveyor.camera_view import ConveyorReference, ConveyorView
from vision.sizing.conveyor.gauge import ConveyorGauge

SEED = 3  # a line whose barriers' faces show wider than the lens blurs


def heights(line, factor=1.0):
    return ConveyorReference(line.spacing_mm, factor * line.height_mm, float(line.camera.centre_mm[2]))


@pytest.mark.parametrize(("factor", "known"), [(1.0, True), (1.3, False), (1.8, False)])
def test_barriers_that_are_lower_than_was_said_give_no_value_or_one_that_says_so(factor, known):
    line = random_thermal_line(SEED)
    *empty, shown = line.pictures(2, 1)
    reading = ConveyorGauge(empty, heights(line, factor), response_exponent=1.0).measure(shown)
    assert not reading.valid or abs(reading.diameter_mm - line.bar.diameter_mm) <= reading.expanded_uncertainty_mm
    assert (reading.valid and reading.expanded_uncertainty_mm < 0.5) is known


def hanging(seed):
    """A line whose barriers hang over a floor on which no rollers show."""
    line = random_foreign_thermal_line(seed)
    return replace(line, roller_light=line.floor_light, lower_mm=0.4 * line.height_mm)


def measured(line, reference):
    *empty, shown = line.pictures(2, 1)
    return ConveyorGauge(empty, reference, response_exponent=line.exponent).measure(shown)


@pytest.mark.parametrize("seed", [48, 55, 902])  # faces of which the picture does not tell how wide they are
def test_barriers_that_hang_over_a_plain_floor_are_not_measured_as_walls(seed):
    line = hanging(seed)
    reading = measured(line, heights(line))
    assert abs(reading.diameter_mm - line.bar.diameter_mm) <= reading.expanded_uncertainty_mm
    assert reading.expanded_uncertainty_mm > 1.5


@pytest.mark.parametrize("u", [0.05, 0.5])
def test_the_interval_of_an_assumed_law_is_that_of_its_samples(u):
    places = np.append(np.linspace(-1, 1, 33), np.full(8, 1.0))
    rng = np.random.default_rng(1)
    samples = rng.choice(places, 400_000) + rng.normal(0, u, 400_000)
    found = [scale._quantile(places, u, share) for share in scale.INTERVAL_95]
    assert found == pytest.approx(np.quantile(samples, scale.INTERVAL_95), abs=0.01)
    assert np.mean((samples >= found[0]) & (samples <= found[1])) == pytest.approx(0.9545, abs=0.001)


def looking(across_mm):
    """A view whose lines look as if the camera hung that far beside the middle of 500 mm, or looked up to 5 degrees."""
    return ConveyorView(np.zeros(2), 0.0, -3000.0, (-0.08, 0.08), 500.0, 50.0, 2700.0, across_mm, u_across_mm=136.0)


@pytest.mark.parametrize(
    ("across_mm", "ends_mm"),
    [(0.0, (-225.0, 225.0)), (-200.0, (-225.0, 35.6)), (300.0, (64.4, 225.0)), (600.0, (364.4, 835.6))],
)
def test_a_camera_that_may_look_across_the_line_hangs_between_the_barriers(across_mm, ends_mm):
    places_mm = scale._places_across_mm(looking(across_mm))
    half_part_mm = np.ptp(ends_mm) / scale.LAW_PARTS / 2
    assert [places_mm[0] - half_part_mm, places_mm[-1] + half_part_mm] == pytest.approx(ends_mm, abs=0.1)
    assert np.diff(places_mm) == pytest.approx(2 * half_part_mm, abs=0.02)


def test_a_told_response_is_doubted_by_as_much_as_another_one_changes_the_diameter():
    line = random_thermal_line(SEED)
    *empty, shown = line.pictures(2, 1)
    told, other = (ConveyorGauge(empty, heights(line), response_exponent=one).measure(shown) for one in (0.9, 0.92))
    assert told.u_light_mm == pytest.approx(other.diameter_mm - told.diameter_mm, rel=0.1)


def test_a_response_that_is_not_told_is_taken_for_a_linear_one_and_u_reaches_to_srgb():
    line = random_thermal_line(SEED)
    *empty, shown = line.pictures(2, 1)
    linear, unknown = (ConveyorGauge(empty, heights(line), response_exponent=one).measure(shown) for one in (1.0, None))
    *empty, shown = (srgb_decoded(picture) for picture in (*empty, shown))
    srgb = ConveyorGauge(empty, heights(line), response_exponent=1.0).measure(shown)
    assert linear.u_light_mm == 0.0
    assert unknown.diameter_mm == pytest.approx(linear.diameter_mm, abs=0.1)
    assert 2 * unknown.u_light_mm == pytest.approx(linear.diameter_mm - srgb.diameter_mm, rel=0.2)
    assert abs(unknown.diameter_mm - srgb.diameter_mm) <= unknown.expanded_uncertainty_mm


def srgb_decoded(picture):
    """The light that a picture would show, in 16 bits, were its codes those of sRGB (IEC 61966-2-1)."""
    code = picture / 255
    light = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
    return np.rint(65535 * light).astype(np.uint16)


def test_faces_that_are_clearly_too_narrow_for_walls_lower_the_trust():
    line = hanging(52)
    reading = measured(line, heights(line))
    assert reading.reasons == Reason.ROUTES_DISAGREE | Reason.BARRIER_HEIGHT
    assert reading.valid
    assert reading.trust_limit == 50
    assert abs(reading.diameter_mm - line.bar.diameter_mm) <= reading.expanded_uncertainty_mm
    walls = measured(line, replace(heights(line), barrier_lower_mm=0.0))
    assert Reason.BARRIER_HEIGHT in walls.reasons, "not a wall, whatever was said"


def test_a_bar_that_is_wider_at_one_end_of_the_picture_is_doubted():
    line = random_thermal_line(SEED)
    thin, thick = (replace(line, bar=replace(line.bar, diameter_mm=one)) for one in (160.0, 168.0))
    *empty, shown = thin.pictures(2, 1)
    mixed = np.concatenate([shown[:240], thick.pictures(2, 1)[2][240:]])
    gauge = ConveyorGauge(empty, heights(line), response_exponent=1.0)
    even = gauge.measure(shown)
    assert not even.reasons
    assert even.u_light_mm == 0, "of a linear camera's picture without loss"
    assert gauge.measure(mixed).reasons == Reason.ROUTES_DISAGREE
    unknown = ConveyorGauge(empty, heights(line)).measure(mixed)
    assert unknown.reasons == Reason.ROUTES_DISAGREE, "a response that is not known moves both ends alike"


@pytest.mark.parametrize("first", [0, 25, 60])
def test_rollers_are_seen_at_any_distance_from_the_barrier_and_a_bar_is_none(first):
    rows = np.arange(400)
    beside = np.full((400, 81), 0.1)
    assert not rollers_show(beside, 0.4)
    beside[:, first : first + 21] += 0.04 * (rows % 60 < 30)[:, None]
    assert rollers_show(beside, 0.4)
    bar = np.full((400, 81), 0.1)
    bar[:, :20] = 0.6 + 0.1 * np.sin(rows / 20)[:, None]
    assert not rollers_show(bar, 0.4)
