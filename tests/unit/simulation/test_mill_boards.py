"""Boards of the simulated mill, and the recording that is written with them."""

import json

import cv2
import numpy as np
import pytest

from appliance.cameras.recording.pairs import Recording
from appliance.simulation import write_recording as writer
from appliance.simulation.bars.bars import bar_at, truth
from appliance.simulation.boards.boards import Board, high_pose, low_pose, observe, random_poses
from appliance.simulation.true_rig import default_rig, random_rig
from appliance.simulation.write_recording import OutputError, write_line


def test_corners_run_along_the_long_side_from_minus_x_plus_y():
    corners = Board(squares=(8, 5), square_mm=50).corners_mm()
    assert corners.shape == (28, 2)
    assert corners[0].tolist() == [-150, 75]
    assert corners[1].tolist() == [-100, 75]
    assert corners[7].tolist() == [-150, 25]
    assert corners[-1].tolist() == [150, -75]
    assert np.abs(corners.mean(axis=0)).max() < 1e-12


def test_the_hidden_errors_move_the_corners_but_not_what_the_user_knows():
    board = Board(square_error_mm=0.5, low_error_mm=0.2, high_error_mm=-0.3)
    assert np.array_equal(board.corners_mm(), 1.01 * Board().corners_mm())
    assert low_pose(board).centre_mm.tolist() == [0, 0, 0.2]
    assert high_pose(board).centre_mm.tolist() == [0, 0, 199.7]


def test_errors_are_drawn_from_the_stated_uncertainties():
    rng = np.random.default_rng(1)
    boards = [Board.with_errors(rng, square_u_mm=0.02, height_u_mm=0.3) for _ in range(3000)]
    assert np.std([board.square_error_mm for board in boards]) == pytest.approx(0.02, rel=0.05)
    for name in ("low_error_mm", "high_error_mm"):
        assert np.std([getattr(board, name) for board in boards]) == pytest.approx(0.3, rel=0.05)
    assert boards[0].square_u_mm == 0.02
    assert boards[0].height_u_mm == 0.3


def test_corners_without_noise_are_those_that_opencv_projects():
    rng = np.random.default_rng(4)
    rig = random_rig(rng)
    seen = observe(rig, rng, Board(low_mm=5.0), poses=1, noise_px=0.0)
    flat = np.column_stack([Board().corners_mm(), np.full(28, 5.0)])
    for camera, pixels in zip(rig.cameras, seen.low, strict=True):
        rotation = cv2.Rodrigues(camera.R)[0]
        expected = cv2.projectPoints(flat, rotation, camera.t, camera.K, camera.dist)[0][:, 0]
        assert np.abs(pixels - expected).max() < 1e-8


def test_noise_has_the_stated_spread_in_both_cameras():
    rig = default_rig()
    clean = observe(rig, np.random.default_rng(4), Board(), poses=0, noise_px=0.0)
    rng = np.random.default_rng(4)
    noisy = [observe(rig, rng, Board(), poses=0, noise_px=0.1) for _ in range(100)]
    for side in range(2):
        errors = np.array([seen.high[side] - clean.high[side] for seen in noisy])
        assert errors.std() == pytest.approx(0.1, rel=0.05)
        assert abs(errors.mean()) < 0.01


def test_boards_are_flat_square_varied_and_inside_both_pictures():
    rng = np.random.default_rng(8)
    rig, board = default_rig(), Board()
    poses = random_poses(rig, rng, board, 15)
    normals = []
    for pose in poses:
        assert pose.axes @ pose.axes.T == pytest.approx(np.eye(2), abs=1e-12)
        normals.append(np.cross(*pose.axes))
        assert all(camera.sees(pose.in_world(board.sheet_mm()), 10) for camera in rig.cameras)
        assert all(normals[-1] @ (camera.centre_mm - pose.centre_mm) > 0 for camera in rig.cameras)
    tilts = np.rad2deg(np.arccos(np.clip(np.array(normals) @ np.array(normals).T, -1, 1)))
    assert tilts.max() > 30
    assert np.ptp([pose.centre_mm for pose in poses], axis=0).min() > 150


def test_a_board_that_does_not_fit_is_a_wrong_call():
    with pytest.raises(ValueError, match="do not fit into both pictures"):
        random_poses(default_rig(), np.random.default_rng(1), Board(square_mm=400), 1)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mill") / "line"
    steps = []
    write_line(folder, 11, 2, poses=2, on_progress=lambda done, total: steps.append((done, total)))
    return folder, steps


def test_a_written_recording_has_the_layout_of_a_rig_folder_with_a_scene(written):
    folder, steps = written
    files = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    assert files == [
        "board.json",
        *(f"calibration/{side}_{number:02}.png" for side in ("left", "right") for number in range(2)),
        *(f"registration/{side}_{height}.png" for side in ("left", "right") for height in ("high", "low")),
        *(f"scenes/line/{side}/{frame:06}.jpg" for side in ("left", "right") for frame in range(2)),
        "scenes/line/truth.json",
        "truth_rig.json",
    ]
    assert steps == [(done, 6) for done in range(1, 7)]


def test_a_written_recording_tells_the_truth_and_plays(written):
    scene = written[0] / "scenes" / "line"
    document = json.loads((scene / "truth.json").read_text())
    assert document["diameter_mm"] == bar_at(11, 0).diameter_mm
    for frame, row in enumerate(document["frames"]):
        assert row == {"frame": f"{frame:06}", **truth(bar_at(11, frame))}
    shapes = [(number, left.shown.shape) for number, left, _ in Recording(scene)]
    assert shapes == [
        (0, (600, 800, 3)),
        (1, (600, 800, 3)),
    ]


def test_the_board_file_holds_nominal_values_and_the_true_rig_the_errors(written):
    board = json.loads((written[0] / "board.json").read_text())
    true_rig = json.loads((written[0] / "truth_rig.json").read_text())
    assert board["squares"] == [8, 5]
    assert board["square_mm"] == 50.0
    assert board["response"] == "srgb"
    assert 0 < abs(true_rig["board"]["square_mm"] - 50) < 0.1
    assert np.array_equal(true_rig["cameras"]["left"]["K"], default_rig().left.K)


def test_pictures_are_written_without_halved_chroma(written):
    data = (written[0] / "scenes" / "line" / "left" / "000000.jpg").read_bytes()
    frame_header = data.index(b"\xff\xc0")
    sampling = data[frame_header + 11 : frame_header + 20 : 3]
    assert sampling == b"\x11\x11\x11"


def test_rendered_boards_are_found_by_a_detector(written):
    for path in [*written[0].glob("calibration/*.png"), *written[0].glob("registration/*.png")]:
        picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        assert picture.ndim == 2
        assert cv2.findChessboardCorners(picture, (7, 4))[0]


def test_a_folder_that_is_not_empty_is_refused_and_stays_as_it_is(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="is not empty"):
        write_line(tmp_path, 1, 1)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_a_failure_half_way_leaves_nothing_behind(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(writer._Writer, "write_scene", full)
    monkeypatch.setattr(writer, "rig_folder_pictures", lambda *_: iter(()))
    with pytest.raises(OutputError, match=r"cannot be written .No space left"):
        write_line(tmp_path / "line", 1, 1)
    assert list(tmp_path.iterdir()) == []


def test_an_output_path_below_a_file_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        write_line(tmp_path / "file" / "line", 1, 1)
