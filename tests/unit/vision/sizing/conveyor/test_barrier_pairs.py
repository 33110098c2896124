"""Which pair of edges the barriers are, half level over rollers, and what a lens that bends does to lines."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy import special

from appliance.cli import main as cli
from appliance.simulation.bars.bars import Bar
from appliance.simulation.foreign_thermal_line import random_foreign_thermal_line
from appliance.simulation.thermal_line import ThermalLine, thermal_camera
from vision.reasons import Reason
from vision.sizing.conveyor.barrier_faces import fitted_feet
from vision.sizing.conveyor.barriers import Barriers, find_barriers
from vision.sizing.conveyor.beside_rollers import crossings_beside_rollers
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge
from vision.sizing.conveyor.lens import Lens, ideal_points, plumb_line
from vision.sizing.conveyor.scale import Scale

SIZE = 480, 640
LINE = ThermalLine(thermal_camera(), spacing_mm=500.0, bar=Bar(165.0, 20.0, 0.0))
GUARDS = ThermalLine(thermal_camera(), spacing_mm=1300.0, height_mm=20.0, seed=1)  # low: their faces are narrow


def drawn_edges(*lines, bend=0.0):
    """Light that is bright outside two lines column(row), blurred; `bend` is lambda of the lens that shows it."""
    columns, rows = np.meshgrid(np.arange(SIZE[1], dtype=np.float64), np.arange(SIZE[0], dtype=np.float64))
    points = ideal_points(np.column_stack([columns.ravel(), rows.ravel()]), bend, SIZE)
    x, y = (one.reshape(SIZE) for one in points.T)
    light = np.full(SIZE, 0.1)
    for side, (slope, start) in zip((-1, 1), lines, strict=True):
        light += 0.3 * special.ndtr(side * (x - slope * y - start) / 1.3)
    return light.astype(np.float32)


@pytest.fixture(scope="module")
def two_pairs():
    """The barriers and, outside them, a pair of brighter guards: an empty picture and one with the bar."""
    return [
        np.maximum(near, np.clip(1.8 * far.astype(np.float64) - 60, 0, 255).astype(np.uint8))
        for near, far in zip(LINE.pictures(1, 1), GUARDS.pictures(2, 0), strict=True)
    ]


def inner_columns(line):
    """Columns, in the picture's middle row, of the feet of a line's inner faces, by projection."""
    row = (SIZE[0] - 1) / 2
    found = []
    for x in (-line.spacing_mm / 2, line.spacing_mm / 2):
        points = np.array([[x, -300.0, 0.0], [x, 300.0, 0.0]])
        camera = line.camera
        (a, b), (c, d) = cv2.projectPoints(points, cv2.Rodrigues(camera.R)[0], camera.t, camera.K, None)[0][:, 0]
        found.append(a + (row - b) * (c - a) / (d - b))
    return tuple(found)


def test_the_user_s_columns_choose_between_two_pairs_that_look_like_barriers(two_pairs):
    light = two_pairs[0].astype(np.float32) / 255
    for line in (LINE, GUARDS):
        wanted = inner_columns(line)
        found = find_barriers(light, (wanted[0] + 12, wanted[1] - 12))
        assert isinstance(found, Barriers)
        assert found.columns(np.array([(SIZE[0] - 1) / 2]))[0] == pytest.approx(wanted, abs=3)


def test_columns_at_which_no_barrier_stands_give_no_barriers(two_pairs):
    light = two_pairs[0].astype(np.float32) / 255
    assert find_barriers(light, (320.0, 420.0)) is Reason.BARRIER_HIDDEN
    left, right = inner_columns(LINE)
    assert isinstance(find_barriers(light, (left + 17, right)), Barriers), "up to 20 px off"
    assert find_barriers(light, (left + 23, right)) is Reason.BARRIER_HIDDEN


def test_the_width_of_faces_is_doubted_where_it_is_fitted_and_not_where_it_is_told():
    barriers = find_barriers(LINE.pictures(1, 0)[0].astype(np.float32) / 255)
    part = LINE.height_mm / (np.linalg.norm(LINE.camera.centre_mm) - LINE.height_mm)
    told, fitted = (fitted_feet(barriers, part, 0.0, 0.01, free=free) for free in (False, True))
    assert (told.part, told.u_part) == (pytest.approx(part), 0)
    assert fitted.part == pytest.approx(part, rel=0.1), "faces of walls are fitted 1 to 8 % too narrow"
    assert 0 < fitted.u_part < 0.05
    for feet in (told, fitted):
        columns = feet.lines @ [(SIZE[0] - 1) / 2, 1]
        assert columns == pytest.approx(inner_columns(LINE), abs=1.0)


def test_the_command_measures_between_the_barriers_that_the_user_names(two_pairs, tmp_path):
    (tmp_path / "line").mkdir()
    for number, picture in enumerate(two_pairs):
        cv2.imwrite(str(tmp_path / "line" / f"{number:06}.png"), picture)
    columns = ",".join(f"{column:.0f}" for column in inner_columns(LINE))
    words = ["measure", str(tmp_path / "line"), "--method", "conveyor", "--barrier-mm", "500", "--barrier-height-mm"]
    assert cli.main([*words, "100", "--barriers", columns, "--output", str(tmp_path / "out.csv")]) == 0
    header, _, row = (tmp_path / "out.csv").read_text().splitlines()
    values = dict(zip(header.split(","), row.split(","), strict=True))
    assert float(values["diameter_mm"]) == pytest.approx(165.0, abs=float(values["expanded_uncertainty_mm"]))


@pytest.mark.parametrize("text", ["250", "a,b", "376,250"])
def test_columns_that_are_no_pair_are_refused_in_one_sentence(text, tmp_path, capsys):
    words = ["measure", str(tmp_path), "--method", "conveyor", "--barrier-mm", "500", "--barriers", text]
    assert cli.main([*words, "--output", str(tmp_path / "out.csv")]) == 2
    error = capsys.readouterr().err
    assert "--barriers" in error
    assert error.count("\n") == 1


def test_edges_that_meet_in_the_picture_are_no_pair():
    assert isinstance(find_barriers(drawn_edges((0.3, 100.0), (-0.3, 530.0))), Barriers)
    assert find_barriers(drawn_edges((0.4, 160.0), (-0.4, 480.0))) is Reason.BARRIER_HIDDEN


@pytest.mark.parametrize("dip", [0.0, 0.1])
def test_half_level_over_rollers_stays_where_the_barrier_ends_from_roller_to_gap(dip):
    rows, offsets = np.arange(240), np.arange(-8.0, 6.25, 0.25)
    barrier = special.ndtr(offsets / 1.2)
    on_roller = ((rows // 30) % 2)[:, None] * special.ndtr((-3.5 - offsets) / 1.2)  # its end is 3.5 px away
    profile = 0.1 + dip * on_roller + (0.5 - 0.1) * barrier
    noise = np.random.default_rng(0).normal(0, 0.004, profile.shape)
    found = crossings_beside_rollers(profile + noise, offsets)
    by_kind = [found.place_px[((rows // 30) % 2) == kind] for kind in (0, 1)]
    assert abs(np.median(by_kind[0])) < 0.05
    assert abs(np.median(by_kind[1])) < 0.25, "a roller's end 3.5 px away lightens the dark side"


@pytest.mark.parametrize("bending", [-0.06, -0.03, 0.04])
def test_the_lens_is_the_one_that_makes_both_barriers_straight(bending):
    lines = (0.12, 150.0), (-0.1, 500.0)
    found = find_barriers(drawn_edges(*lines, bend=bending))
    assert isinstance(found, Barriers)
    assert found.lens.bending == pytest.approx(bending, abs=max(4 * found.lens.u_bending, 0.002))
    rows = np.array([20.0, 240.0, 460.0])
    assert found.columns(rows)[:, 0] == pytest.approx(lines[0][0] * rows + lines[0][1], abs=0.2)
    assert found.columns(rows)[:, 1] == pytest.approx(lines[1][0] * rows + lines[1][1], abs=0.2)


def test_a_lens_that_bends_nothing_is_left_alone():
    found = find_barriers(drawn_edges((0.12, 150.0), (-0.1, 500.0)))
    assert isinstance(found, Barriers)
    assert found.lens == Lens()
    wave = [np.column_stack([100 + 3 * np.sin(np.arange(0.0, 480, 20) / 40), np.arange(0.0, 480, 20)])] * 2
    assert plumb_line(wave, SIZE) == Lens(), "no lens makes a wave straight"


@pytest.mark.parametrize(("wave_px", "believed"), [(0.3, True), (1.0, False)])
def test_a_lens_is_believed_if_it_makes_lines_twice_as_straight(wave_px, believed):
    """Lines that a lens bends by 0.78 px RMS, under a wave that it cannot explain: straighter by 3.8 and by 1.5."""
    y = np.arange(0.0, 480, 5)
    wave = np.column_stack([wave_px * np.sin(y / 7), 0 * y])
    lines = [ideal_points(np.column_stack([m * y + c, y]), -0.03, SIZE) + wave for m, c in ((0.12, 150), (-0.1, 500))]
    found = plumb_line(lines, SIZE)
    assert found.bending == pytest.approx(0.03 if believed else 0, abs=0.002)


def test_what_the_plumb_line_leaves_open_is_in_the_uncertainty():
    line = random_foreign_thermal_line(3)
    reference = ConveyorReference(line.spacing_mm, line.height_mm, float(line.camera.centre_mm[2]))
    *empty, shown = line.pictures(2, 1)
    gauge = ConveyorGauge(empty, reference, response_exponent=line.exponent)
    assert isinstance(gauge.barriers, Barriers)
    assert gauge.barriers.lens.u_bending > 0
    told = gauge.measure(shown)
    doubted = replace(gauge.barriers, lens=replace(gauge.barriers.lens, u_bending=0.05))
    gauge.barriers = doubted
    gauge._scale = lambda _: Scale.of(doubted, reference)
    more = gauge.measure(shown)
    row = np.array([SIZE[0] / 2])
    barriers_px, bar_px = float(doubted.width_px(row)[0]), told.diameter_mm / line.spacing_mm
    half = barriers_px / SIZE[1]
    lens_mm = np.sqrt(more.u_calibration_mm**2 - told.u_calibration_mm**2)
    assert lens_mm == pytest.approx(told.diameter_mm * 0.05 * half**2 * (1 - bar_px**2), rel=0.1)


@pytest.mark.parametrize("seed", [2, 5])
def test_a_lower_edge_that_is_told_says_more_and_holds(seed):
    line = random_foreign_thermal_line(seed)
    camera_mm = float(line.camera.centre_mm[2])
    *empty, shown = line.pictures(2, 1)
    readings = [
        ConveyorGauge(
            empty, ConveyorReference(line.spacing_mm, line.height_mm, camera_mm, lower), response_exponent=line.exponent
        ).measure(shown)
        for lower in (None, line.lower_mm)
    ]
    for reading in readings:
        assert abs(reading.diameter_mm - line.bar.diameter_mm) <= reading.expanded_uncertainty_mm
    assert readings[1].expanded_uncertainty_mm < 0.75 * readings[0].expanded_uncertainty_mm
