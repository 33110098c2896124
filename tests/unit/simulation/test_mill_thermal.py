"""The simulated thermal line: barriers, bar and halo against geometry, and its recording."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from appliance.simulation.bars.bars import Bar
from appliance.simulation.foreign_thermal_line import ForeignThermalLine
from appliance.simulation.sensor import Blur
from appliance.simulation.thermal_line import (
    FADING_PER_M,
    FLOOR,
    TOP,
    WALL_MM,
    ThermalLine,
    random_thermal_line,
    thermal_camera,
    thermal_truth,
)
from appliance.simulation.write_recording import OutputError, write_thermal_recording

STATIONS = np.linspace(-500, 500, 41)
SHARP = Blur(core_px=1.2, halo_part=0.0)


def light_at(line, x_mm, y_mm, z_mm):
    """Light of the empty line where OpenCV projects points, for those inside the picture; and their y."""
    camera = line.camera
    points = np.column_stack([np.broadcast_to(x_mm, y_mm.shape), y_mm, np.full(y_mm.shape, z_mm)])
    pixels = cv2.projectPoints(points, cv2.Rodrigues(camera.R)[0], camera.t, camera.K, camera.dist)[0][:, 0]
    inside = ((pixels > 4) & (pixels < [634, 474])).all(axis=1)
    assert inside.sum() > 15
    light = line.line_light(camera.rays(camera.pixel_grid()))
    x, y = pixels[inside].astype(np.float32).T
    return cv2.remap(light, x[:, None], y[:, None], cv2.INTER_CUBIC)[:, 0], y_mm[inside]


@pytest.mark.parametrize("seed", range(5))
def test_barrier_edges_are_half_way_where_opencv_projects_them(seed):
    line = replace(random_thermal_line(seed), blur=SHARP)
    for side in (-1, 1):
        light, y = light_at(line, side * (line.spacing_mm / 2 + WALL_MM), STATIONS, line.height_mm)
        floor = FLOOR * (1 - FADING_PER_M * y / 1000)
        assert light == pytest.approx(TOP / 2 + floor - FLOOR / 2, abs=0.006)  # 0.004 is a fiftieth of a pixel


@pytest.mark.parametrize("roll_deg", [0.0, 3.0])
def test_inner_faces_are_the_stated_spacing_apart(roll_deg):
    line = ThermalLine(thermal_camera(roll_deg=roll_deg), spacing_mm=500.0, height_mm=0.0, blur=SHARP)
    for side in (-1, 1):
        light, y = light_at(line, side * 250.0, STATIONS, 0.0)
        floor = FLOOR * (1 - FADING_PER_M * y / 1000)
        assert light == pytest.approx(TOP / 2 + floor - FLOOR / 2, abs=0.006)


def test_rollers_lie_as_far_apart_as_stated_from_one_end_of_the_picture_to_the_other():
    line = ForeignThermalLine(thermal_camera(), blur=SHARP, roller_pitch_mm=250.0, roller_mm=150.0)
    y = np.arange(700.0, -705.0, -5.0)[:, None] + np.array([0.0, 0.01, 0.02])
    place = np.mod(y, 250)
    on_roller = line._on_roller(y)
    assert on_roller[(place > 30) & (place < 120)] == pytest.approx(1, abs=1e-3)
    assert on_roller[(place > 180) & (place < 220)] == pytest.approx(0, abs=1e-3)


def test_a_warped_barrier_is_a_wave_and_the_other_stays_straight():
    line = ThermalLine(thermal_camera(), blur=SHARP, warp_mm=20.0, warp_length_mm=1000.0)
    straight = replace(line, warp_mm=0.0)
    outer = -(250.0 + WALL_MM) + 20 * np.sin(2 * np.pi * STATIONS / 1000)
    light, y = light_at(line, outer, STATIONS, line.height_mm)
    assert light == pytest.approx(TOP / 2 + FLOOR * (1 - FADING_PER_M * y / 1000) - FLOOR / 2, abs=0.01)
    rays = line.camera.rays(line.camera.pixel_grid())
    changed = np.abs(line.line_light(rays) - straight.line_light(rays)) > 1e-4
    assert changed[:, :300].any()
    assert not changed[:, 320:].any()


def test_a_hidden_barrier_ends_where_it_is_said_to():
    line = ThermalLine(thermal_camera(), blur=SHARP, hidden="right", hidden_from_mm=50.0)
    light, y = light_at(line, 250.0 + WALL_MM / 2, STATIONS, line.height_mm)
    assert light[y < 20] == pytest.approx(TOP, abs=0.02)
    assert light[y > 80] == pytest.approx(FLOOR, abs=0.01)
    left, _ = light_at(line, -250.0 - WALL_MM / 2, STATIONS, line.height_mm)
    assert left == pytest.approx(TOP, abs=0.02)


def test_the_camera_resolves_the_line_like_the_sources():
    camera = thermal_camera()
    pixels = camera.project(np.array([[-50.0, 0.0, 0.0], [50.0, 0.0, 0.0]]))
    assert 100 / np.hypot(*(pixels[1] - pixels[0])) == pytest.approx(4.8, rel=0.01)


def test_the_recording_begins_empty_and_then_shows_the_bar():
    line = ThermalLine(thermal_camera(), bar=Bar(165.0))
    shown = line.pictures(empty=2, frames=2)
    assert [picture.shape for picture in shown] == [(480, 640)] * 4
    assert [picture.max() > 200 for picture in shown] == [False, False, True, True]
    assert max(picture.max() for picture in replace(line, bar=None).pictures(0, 2)) < 150


def test_frames_differ_by_the_stated_noise_only():
    first, second = ThermalLine(thermal_camera(), noise=0.02).pictures(2, 0)
    difference = first.astype(float) - second
    assert difference.std() / np.sqrt(2) == pytest.approx(np.sqrt((0.02 * 255) ** 2 + 1 / 12), rel=0.03)


def test_random_lines_are_repeatable_and_have_room_for_their_bar():
    assert thermal_truth(random_thermal_line(3), 1, 1) == thermal_truth(random_thermal_line(3), 1, 1)
    for seed in range(100):
        line = random_thermal_line(seed)
        assert abs(line.bar.offset_mm) + line.bar.diameter_mm / 2 < line.spacing_mm / 2


def test_a_written_recording_has_frames_in_the_folder_and_the_truth(tmp_path):
    line = ThermalLine(thermal_camera(roll_deg=3.0), spacing_mm=480.0, height_mm=90.0, bar=Bar(165.0))
    write_thermal_recording(tmp_path / "line", line, empty=1, frames=2)
    files = sorted(path.name for path in (tmp_path / "line").iterdir())
    assert files == ["000000.png", "000001.png", "000002.png", "truth.json"]
    picture = cv2.imread(str(tmp_path / "line" / "000002.png"), cv2.IMREAD_UNCHANGED)
    assert picture.shape == (480, 640)
    document = json.loads((tmp_path / "line" / "truth.json").read_text())
    assert document["diameter_mm"] == 165.0
    assert document["barrier_spacing_mm"] == 480.0
    assert document["barrier_height_mm"] == 90.0
    assert document["camera_centre_mm"] == pytest.approx([0, -800, 2600])
    assert [row["diameter_mm"] for row in document["frames"]] == [None, 165.0, 165.0]
    with pytest.raises(OutputError, match="is not empty"):
        write_thermal_recording(tmp_path / "line", line)
