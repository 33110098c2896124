"""The rig file: written and read as it was, refused when wrong, and slopes against differences."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from appliance.sizing.stereo.rig_file import RigError, load_rig, save_rig
from vision.calibration.bundle_adjustment import project_with_slopes
from vision.calibration.rig import BOARD_NAMES, Rig
from vision.geometry.camera import CAMERA_PARAMETERS, Camera

K = np.array([[2236.0, 0.0, 1353.9], [0.0, 2237.5, 751.7], [0.0, 0.0, 1.0]])
LENSES = [(-0.0105, 0.0061, 3e-4, 2e-4, 0.0), (-0.3, 0.12, 1e-3, -1e-3, -0.02), (0.3, -0.1, 0.0, 2e-3, 0.02)]


def camera(dist=LENSES[1], x=-500.0):
    R = np.asarray(cv2.Rodrigues(np.array([2.4, 0.2, -0.1]))[0])
    return Camera(K, np.array(dist), R, np.array([x, 80.0, 3000.0]), (2704, 1520))


@pytest.fixture
def rig():
    root = np.random.default_rng(1).normal(size=(30, 40))
    return Rig(
        left=camera(),
        right=camera(x=700.0),
        covariance=root @ root.T * 1e-9,
        response="gamma 2.2",
        region_y_mm=(-250.0, 250.0),
        square_relative_u=2e-4,
        low_mm=0.0,
        high_mm=200.0,
        height_u_mm=0.1,
        boards={name: np.arange(8.0).reshape(4, 2) / 3.0 for name in BOARD_NAMES[:3]}
        | {"right_high": np.empty((0, 2))},
        residual_px=0.033,
    )


def world_points(count=50):
    return np.random.default_rng(2).uniform(-600.0, 600.0, (count, 3))


@pytest.mark.parametrize("dist", LENSES)
def test_projection_is_that_of_opencv(dist):
    one, points = camera(dist), world_points()
    expected, _ = cv2.projectPoints(points, cv2.Rodrigues(one.R)[0], one.t, one.K, one.dist)
    assert one.project(points) == pytest.approx(expected.reshape(-1, 2), abs=1e-9)


@pytest.mark.parametrize("dist", LENSES)
def test_undistortion_inverts_opencvs_projection_to_a_ten_billionth(dist):
    ideal = np.random.default_rng(3).uniform((-0.6, -0.34), (0.6, 0.34), (500, 2))
    rays = np.column_stack([ideal, np.ones(500)])
    pixels, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), K, np.array(dist))
    assert np.abs(camera(dist).undistort(pixels.reshape(-1, 2)) - ideal).max() < 1e-10


def test_rays_from_the_centre_pass_through_the_points():
    one, points = camera(), world_points()
    rays = one.rays(one.project(points))
    assert np.linalg.norm(rays, axis=1) == pytest.approx(1.0)
    assert np.abs(np.cross(points - one.centre_mm, rays)).max() < 1e-8


def test_points_behind_the_camera_and_pixels_beyond_the_lens_are_nan():
    one = camera()
    behind = one.centre_mm - 100.0 * one.R[2]
    assert np.isnan(one.project(np.array([behind]))).all()
    assert np.isnan(one.undistort(np.array([[1e6, 1e6], [np.nan, 5.0]]))).all()
    assert one.undistort(np.empty((0, 2))).shape == (0, 2)


@pytest.mark.parametrize("index", range(15), ids=CAMERA_PARAMETERS)
def test_slopes_are_those_of_small_perturbations(index):
    one, points = camera(), world_points()
    _, by_camera, _ = project_with_slopes(one, points)
    step = np.zeros(15)
    step[index] = 1e-3 if index < 4 or index >= 12 else 1e-6
    difference = one.perturbed(step).project(points) - one.perturbed(-step).project(points)
    expected = difference / (2.0 * step[index])
    assert by_camera[:, :, index] == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())


def test_a_rotation_change_turns_from_the_left_and_stays_a_rotation(rig):
    delta = np.zeros(30)
    delta[15 + 11] = 0.3
    right = rig.perturbed(delta).right
    turn = np.array([[np.cos(0.3), -np.sin(0.3), 0.0], [np.sin(0.3), np.cos(0.3), 0.0], [0.0, 0.0, 1.0]])
    assert pytest.approx(turn @ rig.right.R, abs=1e-14) == right.R
    assert np.array_equal(right.t, rig.right.t)
    assert np.array_equal(rig.perturbed(delta).left.R, rig.left.R)


def test_perturbed_refuses_another_number_of_changes(rig):
    with pytest.raises(ValueError, match="delta"):
        rig.perturbed(np.zeros(15))


def test_standard_uncertainty_of_a_parameter_is_the_root_of_its_variance(rig):
    for index, quantity in [(0, lambda rig: rig.left.K[0, 0]), (29, lambda rig: rig.right.t[2])]:
        assert rig.standard_uncertainty(quantity) == pytest.approx(np.sqrt(rig.covariance[index, index]), rel=1e-5)


def test_standard_uncertainty_counts_correlations(rig):
    together = np.zeros((30, 30))
    together[np.ix_([0, 15], [0, 15])] = 0.04
    tied = replace(rig, covariance=together)
    assert tied.standard_uncertainty(lambda rig: rig.left.K[0, 0] - rig.right.K[0, 0]) == pytest.approx(0.0, abs=1e-9)
    assert tied.standard_uncertainty(lambda rig: rig.left.K[0, 0] + rig.right.K[0, 0]) == pytest.approx(0.4)


def test_a_rig_comes_back_from_its_file_bit_for_bit(rig, tmp_path):
    path = tmp_path / "rig.json"
    save_rig(rig, path)
    back = load_rig(path)
    for name in ("K", "dist", "R", "t"):
        assert np.array_equal(getattr(back.right, name), getattr(rig.right, name))
    assert np.array_equal(back.covariance, rig.covariance)
    assert back.boards["right_high"].shape == (0, 2)
    assert back.to_json() == rig.to_json()
    assert [entry.name for entry in tmp_path.iterdir()] == ["rig.json"]


WRONG = {
    "left.K": lambda data: data["left"].update(K=[[1.0, 0.0], [0.0, 1.0]]),
    "left.R": lambda data: data["left"].update(R=[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]),
    "right.t": lambda data: data["right"].pop("t"),
    "right.dist": lambda data: data["right"].update(dist=[0.0, 0.0, "x", 0.0, 0.0]),
    "right.image_size": lambda data: data["right"].update(image_size=[2704.5, 1520]),
    "format_version": lambda data: data.update(format_version=99),
    "response": lambda data: data.update(response="gamma 3"),
    "covariance": lambda data: data["covariance"][3].__setitem__(3, -1.0),
    "boards.left_low": lambda data: data["boards"].pop("left_low"),
    "region_y_mm": lambda data: data.update(region_y_mm=[250.0, -250.0]),
    "residual_px": lambda data: data.update(residual_px=-0.1),
    "low_mm": lambda data: data.update(low_mm=True),
    "has_world": lambda data: data.update(has_world=1),
    "right": lambda data: data.update(right=[]),
    "left": lambda data: data.pop("left"),
}


@pytest.mark.parametrize("key", WRONG)
def test_a_wrong_file_is_refused_in_a_sentence_with_file_and_key(rig, key, tmp_path):
    data = json.loads(rig.to_json())
    WRONG[key](data)
    path = tmp_path / "rig.json"
    path.write_text(json.dumps(data))
    with pytest.raises(RigError) as caught:
        load_rig(path)
    assert str(path) in str(caught.value)
    assert f"{key}: " in str(caught.value)


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"format_version": NaN}', "\u00e4"])
def test_a_text_that_is_no_rig_is_refused(text):
    with pytest.raises(ValueError, match="JSON"):
        Rig.from_json(text)


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999"])
def test_a_number_that_is_none_is_refused(rig, number):
    with pytest.raises(ValueError, match=r"finite|no number"):
        Rig.from_json(rig.to_json().replace('"low_mm": 0.0', f'"low_mm": {number}'))


def test_a_missing_file_and_a_missing_folder_are_named(rig, tmp_path):
    with pytest.raises(RigError, match=r"none\.json: cannot be read"):
        load_rig(tmp_path / "none.json")
    with pytest.raises(RigError, match="cannot be written"):
        save_rig(rig, tmp_path / "none" / "rig.json")


def test_a_rig_that_cannot_be_written_whole_leaves_the_old_file(rig, tmp_path):
    path = tmp_path / "rig.json"
    save_rig(rig, path)
    before = path.read_text()
    with pytest.raises(ValueError, match="JSON"):
        save_rig(replace(rig, residual_px=float("nan")), path)
    assert path.read_text() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["rig.json"]
