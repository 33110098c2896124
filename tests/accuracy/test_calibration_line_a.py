"""Calibration from the path-traced pictures of line_a, against the truth of their renderer."""

import json
import shutil

import cv2
import numpy as np
import pytest

from appliance.sizing.stereo.calibrate_folder import calibrate_folder, report_lines
from vision.calibration.acceptance import CalibrationError
from vision.calibration.checkerboard import Board

# The renderer's origin is not the board's centre.
BOARD_CENTRE_MM = np.array([-10.0, 10.0, 0.0])


@pytest.fixture(scope="module")
def folder(recordings):
    return recordings / "line_a"


@pytest.fixture(scope="module")
def truth(folder):
    cameras = json.loads((folder / "truth_rig.json").read_text())["cameras"]
    return [{key: np.array(value) for key, value in cameras[side].items()} for side in ("left", "right")]


@pytest.fixture(scope="module")
def found(folder):
    return calibrate_folder(folder)


def see(camera, points_mm):
    points = points_mm + BOARD_CENTRE_MM
    return cv2.projectPoints(points, cv2.Rodrigues(camera["R"])[0], camera["t"], camera["K"], camera["dist"])[
        0
    ].reshape(-1, 2)


def centre(camera):
    return -camera["R"].T @ camera["t"] - BOARD_CENTRE_MM


def test_every_picture_is_used_with_a_small_residual(found):
    assert not found.dropped
    assert not found.warnings
    assert len(found.pictures) == 34
    assert found.rig.residual_px < 0.05


def test_the_baseline_is_true_within_its_uncertainty_and_a_tenth_of_a_millimetre(found, truth):
    error_mm = found.baseline_mm - np.linalg.norm(centre(truth[0]) - centre(truth[1]))
    assert abs(error_mm) < min(3.0 * found.baseline_u_mm, 0.1)


def test_intrinsics_are_true_within_their_uncertainty(found, truth):
    u = np.sqrt(np.diag(found.rig.covariance)).reshape(2, 15)
    for camera, true, u_camera in zip((found.rig.left, found.rig.right), truth, u, strict=True):
        errors = np.append((camera.K - true["K"])[[0, 1, 0, 1], [0, 1, 2, 2]], (camera.dist - true["dist"])[:4])
        assert np.abs(errors / u_camera[:8]).max() < 3.5
        assert u_camera[0] < 1.0


def test_the_world_frame_is_that_of_the_low_board(found, truth):
    for camera, true in zip((found.rig.left, found.rig.right), truth, strict=True):
        assert camera.centre_mm == pytest.approx(centre(true), abs=1.5)
        assert np.abs(camera.R - true["R"]).max() < 1e-3


def test_corners_of_the_registration_boards_are_true_to_three_hundredths_of_a_pixel(found, truth, folder):
    board = Board.from_json((folder / "board.json").read_text())
    for height_mm, name in ((0.0, "low"), (200.0, "high")):
        for side, camera in zip(("left", "right"), truth, strict=True):
            errors = found.rig.boards[f"{side}_{name}"] - see(
                camera, board.corners_mm + np.array([0.0, 0.0, height_mm])
            )
            assert np.sqrt(np.mean(errors**2)) < 0.03


@pytest.mark.parametrize("y_mm", [-200.0, 0.0, 200.0])
@pytest.mark.parametrize("axis", [0, 1, 2], ids=["across", "along", "up"])
def test_lengths_of_250_mm_are_true_to_a_twentieth_of_a_millimetre(found, truth, y_mm, axis):
    ends = np.array([[0.0, y_mm, 125.0], [0.0, y_mm, 125.0]])
    ends[:, axis] += [-125.0, 125.0]
    points = []
    cameras = (found.rig.left, found.rig.right)
    for left_px, right_px in zip(see(truth[0], ends), see(truth[1], ends), strict=True):
        rays = [camera.rays(px[None])[0] for camera, px in zip(cameras, (left_px, right_px), strict=True)]
        across = [np.eye(3) - np.outer(ray, ray) for ray in rays]
        weighed = sum(matrix @ camera.centre_mm for matrix, camera in zip(across, cameras, strict=True))
        points.append(np.linalg.solve(across[0] + across[1], weighed))
    assert np.linalg.norm(points[1] - points[0]) == pytest.approx(250.0, abs=0.05)


def test_the_report_names_every_picture_and_the_verdict(found):
    text = "\n".join(report_lines(found))
    for name in ("left_00", "right_14", "left_low", "right_high", "baseline", "world frame"):
        assert name in text
    assert report_lines(found)[-1] == "verdict       good"


@pytest.fixture
def copy(folder, tmp_path):
    """A rig folder that may be damaged: eight pairs and the registration boards."""
    shutil.copy(folder / "board.json", tmp_path)
    shutil.copytree(folder / "registration", tmp_path / "registration")
    (tmp_path / "calibration").mkdir()
    for number in (2, 4, 7, 10, 11, 12, 13, 14):
        for side in ("left", "right"):
            shutil.copy(folder / "calibration" / f"{side}_{number:02d}.png", tmp_path / "calibration")
    return tmp_path


def test_a_black_picture_is_left_out_by_name_and_the_rest_suffices(copy):
    cv2.imwrite(str(copy / "calibration" / "left_04.png"), np.zeros((1520, 2704), np.uint8))
    found = calibrate_folder(copy)
    assert [drop.name for drop in found.dropped] == ["left_04"]
    assert any("left_04" in line and "left out: no board" in line for line in report_lines(found))


def test_without_registration_pictures_the_report_says_so(copy):
    shutil.rmtree(copy / "registration")
    found = calibrate_folder(copy)
    assert not found.rig.has_world
    lines = report_lines(found)
    assert any(line.startswith("world frame   missing") for line in lines)
    assert lines[-1].startswith("verdict       cameras calibrated; nothing can be measured")


def shrink(folder, factor):
    """Write all pictures smaller: looking for a board that is not there takes seconds at full size."""
    for path in folder.rglob("*.png"):
        picture = cv2.resize(cv2.imread(str(path)), None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
        cv2.imwrite(str(path), picture)


def test_a_low_board_in_no_picture_is_refused(copy):
    for side in ("left", "right"):
        cv2.imwrite(str(copy / "registration" / f"{side}_low.png"), np.zeros((1520, 2704), np.uint8))
    shrink(copy, 0.5)
    with pytest.raises(CalibrationError, match="no picture of the low board is usable"):
        calibrate_folder(copy)


@pytest.mark.parametrize("squares", [[7, 4], [9, 6]], ids=["inner corners", "one more each way"])
def test_a_board_of_another_number_of_squares_is_refused_with_the_number_that_the_pictures_show(copy, squares):
    shrink(copy, 0.25)
    with pytest.raises(CalibrationError, match="shows 8 x 5 squares: count squares and not inner corners"):
        calibrate_folder(copy, {"squares": squares})


def test_damage_of_files_is_told_in_one_sentence_with_the_file(copy):
    def refusal(name):
        with pytest.raises(CalibrationError) as caught:
            calibrate_folder(copy)
        assert name in str(caught.value)
        assert "\n" not in str(caught.value)

    picture = copy / "calibration" / "right_07.png"
    data = picture.read_bytes()
    picture.write_bytes(data[: len(data) // 2])
    refusal("right_07.png")
    cv2.imwrite(str(picture), np.zeros((760, 1352), np.uint8))
    refusal("right_07.png")
    (copy / "board.json").write_text("{}")
    refusal("board.json: squares: missing")
    (copy / "board.json").unlink()
    refusal("board.json")


def test_a_folder_without_pictures_is_named(copy):
    shutil.rmtree(copy / "calibration")
    with pytest.raises(CalibrationError, match="calibration: no pictures"):
        calibrate_folder(copy)
