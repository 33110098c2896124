"""`hotgauge capture boards` and `registration`: pairs of board pictures into a rig folder, judged as they come."""

from pathlib import Path

from appliance.cameras.recording.picture_file import read_picture, read_told_coding
from appliance.capture.boards.judged_pairs import Judged, JudgedPairs
from appliance.capture.boards.poses import Poses
from appliance.capture.console import Console
from appliance.capture.error import CaptureError
from appliance.capture.picture_writer import keep_coding, write_picture
from vision.calibration.acceptance import LEAST_PAIRS
from vision.calibration.board_judgement import judge_board, mean_way_px
from vision.calibration.checkerboard import Board
from vision.calibration.rig import SIDES

REGISTRATION_TIME_S = 30.0  # for a registration board to lie still
LOW, HIGH = "low", "high"
MOVED_LEAST_PX = 3.0  # chosen: between the boards at both heights, in the left picture


def capture_boards(pairs: JudgedPairs, poses: Poses, within_s: float, console: Console) -> None:
    """Store poses of the board until they are enough, or the time is over.

    Parameters
    ----------
    pairs : JudgedPairs
    poses : Poses
    within_s : float
        Seconds.
    console : Console

    Raises
    ------
    CaptureError
        The time is over and too few poses were stored for a calibration, or a picture cannot be written.
    CameraError
        The cameras give no pictures.
    """
    if not poses.lacking():
        return
    for judged in pairs.come(within_s):
        trouble = judged.trouble or ("" if poses.is_new(judged) else "as a pose before: move or tilt the board")
        if trouble:
            console.live(f"{poses.number} of {poses.wanted} poses; {trouble}")
            continue
        console.say(f"pose {poses.add(judged)}: {judged.edges}")
        if not poses.lacking():
            return
        console.say(f"  missing: {poses.lacking()}")
    if poses.number < LEAST_PAIRS:
        raise CaptureError(
            f"{poses.number} of the {LEAST_PAIRS} poses that a calibration needs were stored within {within_s:g} s; "
            f"missing: {poses.lacking()}"
        )


def capture_registration(pairs: JudgedPairs, folder: Path, height: str, console: Console) -> None:
    """Store the board that lies flat at one of both heights.

    Parameters
    ----------
    pairs : JudgedPairs
    folder : Path
        The rig folder.
    height : {"low", "high"}
    console : Console

    Raises
    ------
    CaptureError
        Nobody has told the height, no good pair of pictures came in time, or the board lies where it lay for the other
        height.
    CameraError
        The cameras give no pictures.
    """
    if (pairs.board.low_mm if height == LOW else pairs.board.high_mm) is None:
        raise CaptureError(f"{folder}: {height}_mm is not known; give --{height}-mm, its face above the rollers in mm")
    trouble = "no picture came"
    for judged in pairs.come(REGISTRATION_TIME_S):
        trouble = judged.trouble or _not_moved(folder, judged, pairs.board, height)
        if trouble:
            console.live(f"{height} board: {trouble}")
            continue
        keep_coding(folder, judged.pictures[0].coding)
        for side, picture in zip(SIDES, judged.pictures, strict=True):
            write_picture(folder / "registration" / f"{side}_{height}.png", picture)
        console.say(f"{height} board: stored, {judged.edges}")
        return
    raise CaptureError(f"no good pictures of the {height} board within {REGISTRATION_TIME_S:g} s: {trouble}")


def _not_moved(folder: Path, judged: Judged, board: Board, height: str) -> str:
    """Say that the board lies where it lay for the other height; empty where it does not."""
    other = LOW if height == HIGH else HIGH
    path = folder / "registration" / f"left_{other}.png"
    corners_px = judged.boards[0].corners_px
    if not path.is_file() or corners_px is None:
        return ""
    before = judge_board(read_picture(path, read_told_coding(folder)), board)
    if before.corners_px is None or mean_way_px(corners_px, before.corners_px) > MOVED_LEAST_PX:
        return ""
    return f"it lies where it lay for the {other} one: put it at the other height"
