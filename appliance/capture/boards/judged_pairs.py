"""Pairs of pictures of the board as they come from two cameras, judged whether they are worth keeping."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from appliance.cameras.settings import LivenessSettings
from appliance.cameras.source import FramePair, PairSource
from appliance.capture.believed_pairs import believed
from vision.calibration.board_judgement import STILL_PX, BoardPicture, judge_board, mean_way_px
from vision.calibration.checkerboard import Board
from vision.calibration.rig import SIDES
from vision.sent_picture import SentPicture

# chosen: longer than two streams are likely to be apart, so that the two pictures of a pair do not show two poses
STILL_TIME_S = 0.5


class Judged(NamedTuple):
    """A pair of pictures with its boards.

    Attributes
    ----------
    pictures : tuple of SentPicture
    boards : tuple of BoardPicture
    trouble : str
        Why the pair is not stored; empty where it may be.
    """

    pictures: tuple[SentPicture, SentPicture]
    boards: tuple[BoardPicture, BoardPicture]
    trouble: str

    @property
    def edges(self) -> str:
        """Widths of the edges, in words."""
        left, right = (board.edge_width_px for board in self.boards)
        return f"edges {left:.1f} and {right:.1f} px wide"


class JudgedPairs:
    """Two cameras before which somebody holds the board.

    Parameters
    ----------
    source : PairSource
        Not opened yet.
    settings : LivenessSettings
    board : Board

    Attributes
    ----------
    board : Board
    """

    def __init__(self, source: PairSource, settings: LivenessSettings, board: Board) -> None:
        self._source = source
        self._settings = settings
        self.board = board

    def come(self, within_s: float) -> Iterator[Judged]:
        """Open the cameras and judge each pair; one in which the board moves has that as its trouble.

        Parameters
        ----------
        within_s : float
            Seconds after which no more pairs come.

        Raises
        ------
        CaptureError
            The whole time no pair was to be believed.
        CameraError
            The cameras give no pictures.
        """
        before: Judged | None = None
        still_since_s = math.inf
        with self._source as source:
            for pair in believed(source, self._settings, within_s):
                if not isinstance(pair, FramePair):
                    raise TypeError("a source of pairs is needed")
                judged = judge_pair(pair.pictures, self.board)
                motion = _motion(judged, before)
                still_since_s = math.inf if motion else min(still_since_s, pair.exposed_monotonic_s)
                if not motion and pair.exposed_monotonic_s - still_since_s < STILL_TIME_S:
                    motion = "hold the board still"
                yield judged if judged.trouble else judged._replace(trouble=motion)
                before = judged


def judge_pair(pictures: tuple[SentPicture, SentPicture], board: Board) -> Judged:
    """Find and judge the board in both pictures.

    Parameters
    ----------
    pictures : tuple of SentPicture
        Left and right.
    board : Board
    """
    left, right = (judge_board(picture, board) for picture in pictures)
    troubles = [f"{side}: {seen.trouble}" for side, seen in zip(SIDES, (left, right), strict=True) if seen.trouble]
    return Judged(pictures, (left, right), "; ".join(troubles))


def _motion(judged: Judged, before: Judged | None) -> str:
    """Say that the board moves; empty where it has been still since the pair before."""
    ways_px = [
        mean_way_px(now.corners_px, earlier.corners_px)
        for now, earlier in zip(judged.boards, before.boards if before else (), strict=False)
        if now.corners_px is not None and earlier.corners_px is not None
    ]
    if len(ways_px) < len(SIDES):
        return "hold the board still"
    return "" if max(ways_px) <= STILL_PX else f"hold the board still, it moves by {max(ways_px):.1f} px"
