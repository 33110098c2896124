"""The conveyor method: against geometry, and against lines that must not give a wrong value."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from appliance.cli import main as cli
from appliance.simulation.bars.bars import Bar
from appliance.simulation.thermal_line import ThermalLine, random_thermal_line, thermal_camera
from appliance.simulation.write_recording import write_thermal_recording
from vision.reasons import Reason
from vision.sizing.conveyor import gauge as conveyor
from vision.sizing.conveyor import scale
from vision.sizing.conveyor.barriers import Barriers, find_barriers
from vision.sizing.conveyor.camera_view import ConveyorReference, conveyor_view
from vision.sizing.conveyor.gauge import ConveyorGauge
from vision.sizing.conveyor.grey_light import grey_light
from vision.sizing.conveyor.published_experiments import experiment, homography, local_area_widths, traced_widths
from vision.sizing.conveyor.scale import diameters_mm

BAR = Bar(165.0, 20.0, 0.0)
CAMERA_MM = 2600.0


def line_of(camera=None, **changes):
    return replace(ThermalLine(camera or thermal_camera(CAMERA_MM), bar=BAR), **changes)


def reference_of(line, *, camera_known=True):
    height_mm = float(line.camera.centre_mm[2]) if camera_known else None
    return ConveyorReference(line.spacing_mm, line.height_mm, height_mm)


def measured(line, *, camera_known=True):
    pictures = line.pictures(2, 1)
    return ConveyorGauge(pictures[:2], reference_of(line, camera_known=camera_known), response_exponent=1.0).measure(
        pictures[2]
    )


def drawn_barriers(camera, spacing_mm, height_mm=0.0):
    """Barriers exactly where OpenCV projects them."""
    lines = []
    for x in (-spacing_mm / 2, spacing_mm / 2):
        points = np.array([[x, -300.0, height_mm], [x, 300.0, height_mm]])
        pixels = cv2.projectPoints(points, cv2.Rodrigues(camera.R)[0], camera.t, camera.K, camera.dist)[0][:, 0]
        slope = (pixels[1, 0] - pixels[0, 0]) / (pixels[1, 1] - pixels[0, 1])
        lines.append([slope, pixels[0, 0] - slope * pixels[0, 1]])
    columns, rows = camera.image_size
    return Barriers(np.array(lines), np.zeros((rows, columns), np.float32))


@pytest.mark.parametrize("roll_deg", [0.0, 3.0])
@pytest.mark.parametrize(("radius_mm", "across_mm"), [(60.0, 0.0), (82.5, 70.0), (110.0, -50.0)])
def test_a_bar_is_as_thick_as_the_cylinder_that_its_tangents_touch(roll_deg, radius_mm, across_mm):
    camera = thermal_camera(CAMERA_MM, 800.0, roll_deg)
    view = conveyor_view(drawn_barriers(camera, 500.0), ConveyorReference(500.0, None, CAMERA_MM), edge_mm=0.0)
    # tangent points of a circle of that radius on z = 0, from a camera at x = 0: by the circle through both
    height, distance = CAMERA_MM - radius_mm, np.hypot(across_mm, CAMERA_MM - radius_mm)
    to_axis, half = np.arctan2(across_mm, height), np.arcsin(radius_mm / distance)
    ends = []
    for side in (-1, 1):
        x = CAMERA_MM * np.tan(to_axis + side * half)  # where the tangent plane cuts the conveyor
        points = np.column_stack([np.full(3, x), [-200.0, 0.0, 200.0], np.zeros(3)])
        ends.append(cv2.projectPoints(points, cv2.Rodrigues(camera.R)[0], camera.t, camera.K, None)[0][:, 0])
    assert diameters_mm(view, *ends) == pytest.approx(2 * radius_mm, abs=0.15 if roll_deg else 1e-6)


@pytest.mark.parametrize("aside_deg", [-5.0, 4.0])
def test_a_camera_that_looks_across_the_line_is_exact_where_its_place_between_the_barriers_is_known(aside_deg):
    camera = thermal_camera(CAMERA_MM, 800.0, 2.0, aside_deg)
    reference = ConveyorReference(500.0, None, CAMERA_MM)
    blind = conveyor_view(drawn_barriers(camera, 500.0), reference, edge_mm=0.0)
    view = replace(blind, across_mm=0.0)  # the camera hangs over the middle
    radius_mm, across_mm = 80.0, np.sign(aside_deg) * 60.0
    to_axis, half = np.arctan2(across_mm, CAMERA_MM - radius_mm), np.arcsin(radius_mm / np.hypot(across_mm, 2520.0))
    ends = []
    for side in (-1, 1):
        x = CAMERA_MM * np.tan(to_axis + side * half)
        points = np.array([[x, -200.0, 0.0], [x, 300.0, 0.0]])
        ends.append(cv2.projectPoints(points, cv2.Rodrigues(camera.R)[0], camera.t, camera.K, None)[0][:, 0])
    assert diameters_mm(view, *ends) == pytest.approx(2 * radius_mm, abs=1e-6)
    assert np.degrees(abs(np.arctan(view._section()[1]))) == pytest.approx(abs(aside_deg), abs=0.5)
    assert np.abs(diameters_mm(blind, *ends) - 2 * radius_mm).min() > 0.3, "taken for a rolled one"


def test_the_vanishing_point_tells_the_cameras_height_when_the_lens_is_known():
    camera = thermal_camera(2900.0, 1100.0)
    focal_share = camera.K[0, 0] / camera.image_size[0]
    view = conveyor_view(drawn_barriers(camera, 480.0), ConveyorReference(480.0), focal_share, edge_mm=0.0)
    assert view.camera_height_mm == pytest.approx(2900.0, rel=0.002)


@pytest.mark.parametrize("seed", [7, 8])
@pytest.mark.parametrize("camera_known", [True, False])
def test_diameters_are_true_within_what_is_stated(seed, camera_known):
    line = random_thermal_line(seed)
    reading = measured(line, camera_known=camera_known)
    assert reading.valid
    assert abs(reading.diameter_mm - line.bar.diameter_mm) <= reading.expanded_uncertainty_mm
    assert reading.expanded_uncertainty_mm < (0.6 if camera_known else 3.0)


@pytest.mark.parametrize(
    ("constant", "field", "off_mm"),
    [("U_BARRIER_HEIGHT_MM", "barrier_height_mm", 1.0), ("U_CAMERA_HEIGHT_MM", "camera_height_mm", 10.0)],
)
def test_what_a_tape_leaves_open_of_a_height_counts_as_much_as_it_moves_the_diameter(
    monkeypatch, constant, field, off_mm
):
    line = line_of()
    pictures, reference = line.pictures(2, 1), reference_of(line)
    reading = ConveyorGauge(pictures[:2], reference, response_exponent=1.0).measure(pictures[2])
    taped = replace(reference, **{field: getattr(reference, field) + off_mm})
    moved_mm = (
        ConveyorGauge(pictures[:2], taped, response_exponent=1.0).measure(pictures[2]).diameter_mm - reading.diameter_mm
    )
    monkeypatch.setattr(scale, constant, 0.0)
    without = ConveyorGauge(pictures[:2], reference, response_exponent=1.0).measure(pictures[2])
    counted_mm = np.sqrt(reading.u_model_mm**2 - without.u_model_mm**2)
    assert abs(moved_mm) > 0.001
    assert counted_mm == pytest.approx(abs(moved_mm), rel=0.1)


def test_without_the_correction_the_source_found_5_to_10_mm_too_much():
    camera = thermal_camera(CAMERA_MM)
    reading = measured(line_of(camera))
    sine = BAR.diameter_mm / 2 / (CAMERA_MM - BAR.diameter_mm / 2)
    on_the_conveyor_mm = BAR.diameter_mm * (1 + sine) / np.sqrt(1 - sine**2)
    assert on_the_conveyor_mm - BAR.diameter_mm > 5
    assert reading.diameter_mm == pytest.approx(BAR.diameter_mm, abs=0.5)


BROKEN = {
    "no bar": (line_of(bar=None), Reason.NO_BAR),
    "bar touching a barrier": (line_of(bar=replace(BAR, offset_mm=164.0)), Reason.EDGE_NOT_FOUND),
    "barrier half hidden": (line_of(hidden="left", hidden_from_mm=0.0), Reason.BARRIER_HIDDEN),
    "barrier warped": (line_of(warp_mm=8.0), Reason.BARRIER_BENT),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_line_that_cannot_be_measured_gives_no_value(name):
    line, reason = BROKEN[name]
    reading = measured(line)
    assert not reading.valid
    assert reason in reading.reasons
    assert np.isnan(reading.diameter_mm)


def test_a_bar_at_a_barrier_would_be_wrong_if_nobody_looked(monkeypatch):
    line, _ = BROKEN["bar touching a barrier"]
    monkeypatch.setattr(conveyor, "_touches", lambda *_: False)
    reading = measured(line)
    assert not reading.valid or abs(reading.diameter_mm - BAR.diameter_mm) > reading.expanded_uncertainty_mm


def moved_since(line):
    """A gauge whose background was taken before the camera sank by 1.5 %, and a picture taken after."""
    sunk = replace(line, camera=replace(thermal_camera(0.985 * CAMERA_MM, 0.985 * 800.0), K=line.camera.K))
    return ConveyorGauge(line.pictures(2, 0), reference_of(line), response_exponent=1.0).measure(sunk.pictures(0, 1)[0])


def test_a_camera_that_has_moved_since_its_background_gives_no_value():
    reading = moved_since(line_of())
    assert not reading.valid
    assert reading.reasons == Reason.CAMERA_MOVED


def test_a_camera_that_has_moved_would_be_wrong_if_nobody_looked(monkeypatch):
    monkeypatch.setattr(conveyor, "CAMERA_MOVED_PX", np.inf)
    reading = moved_since(line_of())
    assert abs(reading.diameter_mm - BAR.diameter_mm) > max(2 * reading.expanded_uncertainty_mm, 1.0)


def test_a_barrier_that_something_hides_while_a_bar_is_there_gives_no_value():
    line = line_of()
    reading = ConveyorGauge(line.pictures(2, 0), reference_of(line), response_exponent=1.0).measure(
        replace(line, hidden="left", hidden_from_mm=-5000.0).pictures(0, 1)[0]
    )
    assert not reading.valid
    assert Reason.BARRIER_HIDDEN in reading.reasons


@pytest.mark.parametrize("roll_deg", [-3.0, 3.0])
def test_a_camera_that_is_rolled_measures_as_well(roll_deg):
    reading = measured(line_of(thermal_camera(CAMERA_MM, 800.0, roll_deg)))
    assert reading.valid
    assert abs(reading.diameter_mm - BAR.diameter_mm) <= reading.expanded_uncertainty_mm


@pytest.mark.parametrize("aside_deg", [-5.0, -3.0, 3.0, 5.0])
@pytest.mark.parametrize("known", ["barriers' and camera's height", "barriers' height", "nothing"])
def test_a_camera_that_looks_across_the_line_measures_as_well(aside_deg, known):
    line = line_of(thermal_camera(CAMERA_MM, 800.0, 1.0, aside_deg), bar=replace(BAR, offset_mm=-60.0))
    height_mm = None if known == "nothing" else line.height_mm
    camera_mm = CAMERA_MM if known.endswith("camera's height") else None
    pictures = line.pictures(3, 1)
    reading = ConveyorGauge(
        pictures[:3], ConveyorReference(500.0, height_mm, camera_mm), response_exponent=1.0
    ).measure(pictures[3])
    assert reading.valid
    assert abs(reading.diameter_mm - BAR.diameter_mm) <= reading.expanded_uncertainty_mm
    assert reading.expanded_uncertainty_mm < (5.0 if known == "nothing" else 0.6)


def test_barriers_are_upright_and_at_one_distance_in_a_homographic_picture():
    line = line_of()
    barriers = find_barriers(np.mean([grey_light(one) for one in line.pictures(2, 0)], axis=0, dtype=np.float32))
    rows = np.array([50.0, 250.0, 479.0])
    ends = barriers.columns(rows)
    for side in (0, 1):
        points = np.column_stack([ends[:, side], rows])[None]
        moved = cv2.perspectiveTransform(points, homography(barriers, "fitted"))[0]
        assert moved[:, 0] == pytest.approx(ends[-1, side], abs=0.01)


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_experiments_count_pixels_to_within_what_pixels_allow(number):
    line = line_of()
    pictures = line.pictures(2, 1)
    barriers = find_barriers(np.mean([grey_light(one) for one in pictures[:2]], axis=0, dtype=np.float32))
    sized = experiment(number, pictures[2], barriers, line.spacing_mm)
    assert sized.mean() == pytest.approx(BAR.diameter_mm, abs=10)
    assert experiment(number, pictures[0], barriers, line.spacing_mm).size == 0


def test_the_homography_is_the_mean_of_five_and_not_one_of_them():
    line = line_of(thermal_camera(CAMERA_MM, roll_deg=1.0))
    barriers = find_barriers(np.mean([grey_light(one) for one in line.pictures(2, 0)], axis=0, dtype=np.float32))
    rows = len(barriers.light)
    each = []
    for high in (0.0, 0.1 * rows, 0.2 * rows, 0.3 * rows, 0.4 * rows):
        (a, b), (c, d) = barriers.columns(np.array([rows - 1.0, high]))
        seen = np.array([[a, rows - 1], [b, rows - 1], [c, high], [d, high]], np.float32)
        wanted = np.array([[a, rows - 1], [b, rows - 1], [a, high], [b, high]], np.float32)
        each.append(cv2.getPerspectiveTransform(seen, wanted))
    assert homography(barriers) == pytest.approx(np.mean([one / one[2, 2] for one in each], axis=0), abs=1e-6)
    assert np.abs(homography(barriers) - each[0]).max() > 1e-4


def drawn_edges(slope=0.1, columns=(30, 90), shape=(120, 160)):
    """Thin edges of a bar that runs obliquely, a short boundary beside it, and one inside it."""
    edges = np.zeros(shape, bool)
    rows = np.arange(shape[0])
    for column in columns:
        edges[rows, np.rint(column + slope * rows).astype(int)] = True
    edges[50:62, 20] = edges[70:85, 70] = True
    return edges, 0.5 * sum(columns) + slope * rows


def test_tracing_counts_the_pixels_between_the_longest_boundary_on_each_side():
    edges, middle = drawn_edges()
    assert np.abs(traced_widths(edges, middle) - 60).max() <= 0.5
    edges[40:44] = False  # both boundaries broken: the longer halves are B_max
    width_px = traced_widths(edges, middle)
    assert np.isnan(width_px[:44]).all()
    assert np.abs(width_px[44:] - 60).max() <= 0.5


def test_the_local_area_moves_down_and_across_and_its_lines_are_as_far_apart_as_the_edges():
    edges, _ = drawn_edges()
    place, width_px = local_area_widths(edges, (100, 20), 5)
    assert np.abs(width_px - 60).max() < 0.3
    assert len(np.unique(place)) == 21
    assert np.bincount(place.astype(int)).max() > 2


@pytest.mark.parametrize("number", [1, 2, 3, 4])
@pytest.mark.parametrize("scale", [1, 2, 3])
def test_every_experiment_sizes_a_bar_of_any_width_in_pixels(number, scale):
    line = line_of()
    pictures = [cv2.resize(one, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC) for one in line.pictures(2, 1)]
    barriers = find_barriers(np.mean([grey_light(one) for one in pictures[:2]], axis=0, dtype=np.float32))
    sized = experiment(number, pictures[2], barriers, line.spacing_mm)
    assert sized.size > 20
    assert sized.mean() == pytest.approx(BAR.diameter_mm, abs=4)


def test_wrong_calls_are_named():
    pictures = line_of().pictures(1, 0)
    with pytest.raises(ValueError, match="spacing_mm"):
        ConveyorReference(-1.0)
    with pytest.raises(ValueError, match="camera_height_mm"):
        ConveyorReference(500.0, 100.0, 150.0)
    with pytest.raises(ValueError, match="barrier_height_mm"):
        ConveyorReference(100.0, 500.0)
    with pytest.raises(ValueError, match="compensation_mm"):
        ConveyorGauge(pictures, ConveyorReference(500.0), np.nan)
    with pytest.raises(ValueError, match="empty"):
        ConveyorGauge([], ConveyorReference(500.0))
    with pytest.raises(ValueError, match="picture"):
        ConveyorGauge(pictures, ConveyorReference(500.0), response_exponent=1.0).measure(pictures[0][:100])


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("thermal") / "recording"
    write_thermal_recording(folder, line_of(), empty=3, frames=2)
    return folder


def command(recording, output, *more):
    return cli.main(["measure", str(recording), "--method", "conveyor", "--output", str(output), *map(str, more)])


@pytest.mark.parametrize("background", [False, True])
def test_the_command_measures_frames_and_finds_the_empty_ones(recording, tmp_path, background):
    more = ("--background", recording / "000000.png") if background else ()
    output = tmp_path / "out.jsonl"
    assert command(recording, output, "--barrier-mm", 500, "--barrier-height-mm", 100, *more) == 0
    rows = [json.loads(text) for text in output.read_text().splitlines()]
    assert [row["valid"] for row in rows] == [False, False, False, True, True]
    assert [row["reasons"] for row in rows[:3]] == [["no_bar"]] * 3
    for row in rows[3:]:
        assert row["method"] == "conveyor"
        assert row["diameter_mm"] == pytest.approx(165.0, abs=row["expanded_uncertainty_mm"])


def test_a_compensation_is_added_when_asked_for(recording, tmp_path):
    found = []
    for more in ((), ("--compensation-mm", -2.5)):
        assert command(recording, tmp_path / "out.jsonl", "--barrier-mm", 500, "--barrier-height-mm", 100, *more) == 0
        found.append(json.loads((tmp_path / "out.jsonl").read_text().splitlines()[-1])["diameter_mm"])
    assert found[1] - found[0] == pytest.approx(-2.5)


@pytest.mark.parametrize("offsets_mm", [(0.0, 0.0, 0.0), (-40.0, 0.0, 40.0), (0.0, 3.0, 30.0)])
def test_a_recording_without_an_empty_frame_is_measured_where_its_barriers_show_beside_the_bar(tmp_path, offsets_mm):
    for number, offset_mm in enumerate(offsets_mm):
        picture = line_of(bar=replace(BAR, offset_mm=offset_mm), seed=number).pictures(0, 1)[0]
        (tmp_path / "recording").mkdir(exist_ok=True)
        cv2.imwrite(str(tmp_path / "recording" / f"{number:06}.png"), picture)
    assert command(tmp_path / "recording", tmp_path / "out.jsonl", "--barrier-mm", 500, "--barrier-height-mm", 100) == 0
    rows = [json.loads(text) for text in (tmp_path / "out.jsonl").read_text().splitlines()]
    assert all(row["valid"] for row in rows)
    for row in rows:
        assert row["diameter_mm"] == pytest.approx(BAR.diameter_mm, abs=row["expanded_uncertainty_mm"])


def test_a_background_of_another_size_is_refused(recording, tmp_path, capsys):
    cv2.imwrite(str(tmp_path / "small.png"), np.zeros((100, 100), np.uint8))
    output = tmp_path / "out.jsonl"
    assert command(recording, output, "--barrier-mm", 500, "--background", tmp_path / "small.png") == 2
    assert "small.png" in capsys.readouterr().err
    assert not output.exists()


@pytest.mark.parametrize(
    ("more", "named"),
    [
        ((), "--barrier-mm"),
        (("--barrier-mm", 0), "lengths above 0"),
        (("--barrier-mm", 500, "--rig", "rig.json"), "--rig"),
        (("--barrier-mm", 500, "--background", "absent.png"), "absent.png"),
        (("--barrier-mm", 500, "--compensation-mm", "nan"), "--compensation-mm"),
    ],
)
def test_measure_refuses_conveyor_options_that_cannot_be_in_one_sentence(recording, tmp_path, capsys, more, named):
    assert command(recording, tmp_path / "out.jsonl", *more) == 2
    error = capsys.readouterr().err
    assert named in error
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_black_hot_camera_is_not_an_empty_line():
    line = line_of()
    pictures = [255 - picture for picture in line.pictures(2, 1)]
    reading = ConveyorGauge(pictures[:2], reference_of(line), response_exponent=1.0).measure(pictures[2])
    assert reading.reasons.names == ["edge_not_found", "low_contrast"]


@pytest.mark.parametrize(("dimmed_by", "reasons"), [(0.4, []), (0.2, ["edge_not_found", "low_contrast"])])
def test_a_camera_that_dims_the_line_for_the_bar_is_not_an_empty_line(dimmed_by, reasons):
    line = line_of()
    *empty, shown = (picture.astype(np.float64) for picture in line.pictures(2, 1))
    gain = 255 / max(picture.max() for picture in empty)
    empty = [np.rint(gain * picture).astype(np.uint8) for picture in empty]  # stretched to full scale
    reading = ConveyorGauge(empty, reference_of(line), response_exponent=1.0).measure(
        np.rint(dimmed_by * shown).astype(np.uint8)
    )
    assert reading.reasons.names == reasons
    if not reasons:  # brighter than the empty line all the same
        assert abs(reading.diameter_mm - BAR.diameter_mm) <= reading.expanded_uncertainty_mm
    assert ConveyorGauge(empty, reference_of(line), response_exponent=1.0).measure(empty[0]).reasons.names == ["no_bar"]
