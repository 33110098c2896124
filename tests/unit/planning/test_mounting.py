"""Optics of a planned mounting, and what the gauge is expected to state there."""

import math

import pytest

from appliance.cli import main as cli
from appliance.planning import expected as planned
from appliance.planning.drawing import mounting_figure
from appliance.planning.expected import PARTS, Expected, check_view, expected, true_rig
from appliance.planning.mounting import Mounting

MILL = Mounting(800, 600, 4.8, 9.6, 8.0, 3000.0, 1500.0, 55.0, 500.0, 2.0)
REGION_MM = (-250.0, 250.0)


def test_a_pixel_is_what_the_thin_lens_shows():
    near = MILL._replace(distance_mm=1000.0, focal_mm=50.0, pixel_um=5.0)
    magnification = 50.0 / (1000.0 - 50.0)
    assert near.pixel_mm == pytest.approx(0.005 / magnification)
    assert near.view_mm == pytest.approx((800 * near.pixel_mm, 600 * near.pixel_mm))


def test_a_point_at_the_ends_of_the_depth_of_field_is_blurred_by_one_pixel():
    mounting = MILL._replace(focal_mm=50.0, f_number=2.8)
    for distance_mm in mounting.depth_of_field_mm:
        image_mm = 1 / (1 / 50.0 - 1 / mounting.distance_mm)
        other_mm = 1 / (1 / 50.0 - 1 / distance_mm)
        aperture_mm = 50.0 / 2.8
        blur_mm = aperture_mm * abs(other_mm - image_mm) / other_mm
        assert blur_mm == pytest.approx(0.0048, rel=0.02)
    assert math.isinf(MILL._replace(distance_mm=50_000.0).depth_of_field_mm[1])


def test_the_longest_exposure_is_one_pixel_of_motion():
    assert MILL._replace(exposure_us=MILL.exposure_max_us).motion_blur_px == pytest.approx(1.0)
    assert math.isinf(MILL._replace(speed_m_s=0.0).exposure_max_us)


def test_the_cameras_stand_where_the_plan_says():
    rig = true_rig(MILL, REGION_MM)
    left, right = (camera.centre_mm for camera in rig.cameras)
    assert right - left == pytest.approx([1500.0, 0.0, 0.0])
    assert math.dist(left, (0.0, 0.0, 120.0)) == pytest.approx(3000.0)
    check_view(rig, 250.0)


def test_the_picture_shows_the_cameras_where_the_plan_has_them():
    cameras_m = [camera.centre_mm / 1000 for camera in true_rig(MILL, REGION_MM).cameras]
    drawn = [
        [line.get_xydata()[0] for line in axes.lines if line.get_marker() == "s"]
        for axes in mounting_figure(MILL, 250.0, REGION_MM).axes
    ]
    assert drawn[0] == [pytest.approx(place_m[[0, 2]]) for place_m in cameras_m]
    assert drawn[1] == [pytest.approx(cameras_m[0][1:])]


def test_the_table_says_all_parts_of_the_uncertainty_that_the_gauge_states_unless_told(monkeypatch, capsys):
    parts_mm = {part: 0.001 * place for place, part in enumerate(PARTS, start=1)}
    ovalities_mm = []

    def measured(_mounting, diameters_mm, _region, ovality_mm, _progress):
        ovalities_mm.append(ovality_mm)
        return [Expected(diameter_mm, 0.1, 0.0, parts_mm, []) for diameter_mm in diameters_mm]

    monkeypatch.setattr(planned, "expected", measured)
    words = ["--sensor", "800x600", "--pixel-um", "4.8", "--focal-mm", "9.6", "--distance-m", "3"]
    assert cli.main(["plan", *words]) == 0
    assert cli.main(["plan", *words, "--ovality", "0"]) == 0
    assert ovalities_mm == [None, 0.0]
    *_, header, _, _, row = capsys.readouterr().out.splitlines()
    assert header.split()[-len(PARTS) :] == list(PARTS)
    assert [float(part) for part in row.split()[-len(PARTS) :]] == list(parts_mm.values())


def test_the_error_of_simulated_bars_is_within_the_expected_uncertainty_which_grows_with_the_bar():
    shown = []
    found = expected(MILL, (80.0, 250.0), REGION_MM, None, lambda done, of: shown.append((done, of)))
    for one in found:
        assert abs(one.error_mm) <= one.expanded_mm
        parts = math.sqrt(sum(part**2 for part in one.parts_mm.values()))
        assert one.expanded_mm == pytest.approx(2 * parts, rel=0.1)
        assert one.parts_mm["shape"] > 0.3 * 0.006 * one.diameter_mm / math.sqrt(12), "rounds are 0.6 % oval"
    assert found[0].expanded_mm < found[1].expanded_mm < 0.87, "as docs/methods/trust.md says of 250 mm"
    assert shown[-1] == (2, 2)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--focal-mm", "50"], "do not hold the region"),
        (["--baseline-m", "4"], "less than 1.2 times"),
        (["--bars", "250", "80"], "smallest diameter first"),
        (["--output", "plan.doc"], "ends in .pdf, .png, .svg"),
        (["--distance-m", "0.01"], "not far enough"),
    ],
)
def test_an_impossible_plan_is_refused_in_one_sentence(capsys, options, said):
    words = ["--sensor", "800x600", "--pixel-um", "4.8", "--focal-mm", "9.6", "--distance-m", "3", *options]
    assert cli.main(["plan", *words]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1
