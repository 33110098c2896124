"""The board poses of a rig folder: what they show so far, and what is missing for a calibration."""

import re
from pathlib import Path

from appliance.cameras.recording.picture_file import read_picture, read_told_coding
from appliance.capture.boards.judged_pairs import Judged, judge_pair
from appliance.capture.picture_writer import keep_coding, write_picture
from vision.calibration.acceptance import COVERED_LEAST, TILT_LEAST_DEG
from vision.calibration.board_judgement import Array, Seen, is_new, seen_so_far
from vision.calibration.checkerboard import Board
from vision.calibration.rig import SIDES


class Poses:
    """The poses of a rig folder, those that were there before included.

    Parameters
    ----------
    folder : Path
    board : Board
    wanted : int
        Number of poses.

    Attributes
    ----------
    wanted : int
    """

    def __init__(self, folder: Path, board: Board, wanted: int) -> None:
        self._folder = folder / "calibration"
        self._board = board
        self.wanted = wanted
        self._corners: tuple[list[Array], list[Array]] = ([], [])
        self._size = (1, 1)
        self._next = 0
        self._resume()

    @property
    def number(self) -> int:
        """Of poses that are usable on both sides."""
        return len(self._corners[0])

    def add(self, judged: Judged) -> str:
        """Store a pair; its number in words."""
        name = f"{self._next:02d}"
        keep_coding(self._folder.parent, judged.pictures[0].coding)
        for side, picture in zip(SIDES, judged.pictures, strict=True):
            write_picture(self._folder / f"{side}_{name}.png", picture)
        self._note(judged)
        self._next += 1
        return name

    def is_new(self, judged: Judged) -> bool:
        """Whether the pose differs from all earlier ones, in both pictures."""
        return all(
            board.corners_px is not None and is_new(board.corners_px, earlier)
            for board, earlier in zip(judged.boards, self._corners, strict=True)
        )

    @property
    def seen(self) -> tuple[Seen, Seen]:
        """What the poses show so far, left and right."""
        left, right = (seen_so_far(corners, self._size, self._board) for corners in self._corners)
        return left, right

    def lacking(self) -> str:
        """What is missing, in words; empty where the poses are enough."""
        wanted: list[str] = []
        if more := max(0, self.wanted - self.number):
            wanted.append(f"{more} pose{'s' * (more > 1)}")
        covered = [seen.covered_share for seen in self.seen]
        if min(covered) < COVERED_LEAST:
            left, right = (f"{100 * share:.0f}" for share in covered)
            wanted.append(f"more of the pictures ({left} and {right} of {100 * COVERED_LEAST:.0f} % covered)")
        tilt_deg = min(seen.tilt_deg for seen in self.seen)
        if tilt_deg < TILT_LEAST_DEG:
            wanted.append(f"tilt ({tilt_deg:.0f} of {TILT_LEAST_DEG:.0f} degrees)")
        return ", ".join(wanted)

    def unseen(self) -> list[str]:
        """Corners of each picture in which no board was, a line each."""
        return [
            f"no board was in the {side} picture's {', '.join(seen.missing)}"
            for side, seen in zip(SIDES, self.seen, strict=True)
            if seen.missing
        ]

    def _note(self, judged: Judged) -> None:
        self._size = judged.pictures[0].size
        for earlier, board in zip(self._corners, judged.boards, strict=True):
            if board.corners_px is not None:
                earlier.append(board.corners_px)

    def _resume(self) -> None:
        """Take in the pairs that the folder holds already."""
        told = read_told_coding(self._folder.parent)
        for left in sorted(self._folder.glob("left_*.png")):
            number = re.fullmatch(r"left_(\d+)", left.stem)
            right = left.with_name(left.name.replace("left", "right"))
            if number is None:
                continue
            self._next = max(self._next, int(number[1]) + 1)
            if right.is_file():
                judged = judge_pair((read_picture(left, told), read_picture(right, told)), self._board)
                if not judged.trouble:
                    self._note(judged)
