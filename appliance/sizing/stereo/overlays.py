"""What route V saw, drawn over its pictures as the dissertation draws it (figures 3.25 to 3.27, 4.3 to 4.5)."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry.homography import solved, transformed
from vision.pictures import Picture, grey
from vision.sizing.virtual_board.aligned_pair import AlignedPair
from vision.sizing.virtual_board.boundaries_of_interest import boundaries_of_interest, hot_mask
from vision.sizing.virtual_board.reading import VirtualBoardReading

Array = NDArray[np.float64]
Colour = tuple[int, int, int]  # blue, green, red

EDGE_COLOUR: Colour = (60, 220, 60)
WINDOW_COLOUR: Colour = (255, 255, 255)
DISCARDED_COLOUR: Colour = (40, 40, 255)
POLYGON_COLOURS: tuple[Colour, Colour] = ((80, 80, 255), (255, 200, 60))  # P_l, P_r
BOARD_COLOUR: Colour = (0, 220, 255)
WINDOW_TICK_PX = 14  # length of the lines that part windows, on either side of the picture


def write_overlays(folder: Path, frame: int, pair: AlignedPair, reading: VirtualBoardReading) -> None:
    """Write `boundaries_NNNNNN.png` and `alignment_NNNNNN.png` of a frame.

    Parameters
    ----------
    folder : Path
    frame : int
    pair : AlignedPair
        Of the frame, as the gauge left it.
    reading : VirtualBoardReading

    Raises
    ------
    OSError
        A file cannot be written.
    """
    pictures = {"boundaries": boundaries(pair, reading)}
    if len(pair.edges) > 1:  # one camera aligns nothing
        pictures["alignment"] = two_colours(pair)
    for name, picture in pictures.items():
        _, data = cv2.imencode(".png", picture)
        (folder / f"{name}_{frame:06d}.png").write_bytes(data.tobytes())


def boundaries(pair: AlignedPair, reading: VirtualBoardReading) -> Picture:
    """Left region with the edge points that route V found, and its windows; discarded ones in red.

    Parameters
    ----------
    pair : AlignedPair
    reading : VirtualBoardReading

    Returns
    -------
    ndarray of uint8, shape (rows, columns, 3)
    """
    shown = _colour(pair.alignment.left.picture)
    for side in pair.edges[0].sides:
        there = np.isfinite(side.column)
        rows, columns = np.rint(side.row[there]).astype(int), np.rint(side.column[there]).astype(int)
        inside = (columns >= 0) & (columns < shown.shape[1]) & (rows >= 0) & (rows < shown.shape[0])
        shown[rows[inside], columns[inside]] = EDGE_COLOUR
    windows = max(1, reading.windows_total)
    height = shown.shape[0] // windows
    for window in range(windows):
        kept = window < len(reading.window_kept) and bool(reading.window_kept[window])
        colour = WINDOW_COLOUR if kept else DISCARDED_COLOUR
        shown[window * height, :WINDOW_TICK_PX] = shown[window * height, -WINDOW_TICK_PX:] = colour
        if not kept:
            shown[window * height : (window + 1) * height, :3] = colour
    return shown


def two_colours(pair: AlignedPair) -> Picture:
    """Left region in red and the aligned right one in cyan, both polygons (fig. 4.4), and the virtual board's corners.

    Parameters
    ----------
    pair : AlignedPair

    Returns
    -------
    ndarray of uint8, shape (rows, columns, 3)
    """
    alignment, height_mm = pair.alignment, pair.height.height_mm
    left, right = (grey(picture) for picture in (alignment.left.picture, alignment.right_on_left(height_mm)))
    shown = np.dstack([right, right, left])
    outlines = pair.outline, pair.edges[-1].outline
    transforms = np.eye(3), alignment.right_to_left(height_mm)
    for outline, transform, colour in zip(outlines, transforms, POLYGON_COLOURS, strict=True):
        if outline is not None:
            moved = outline.moved(transform)
            _polygon(shown, np.concatenate([moved.first, moved.second[::-1]]), colour)
    corners, _ = alignment.boards.corners(height_mm, projective=alignment.projective, slope=alignment.slope)
    for x, y in transformed(solved(alignment.left.to_ideal, np.eye(3)), corners):
        cv2.drawMarker(shown, (round(float(x)), round(float(y))), BOARD_COLOUR, cv2.MARKER_CROSS, 7)
    return shown


def edges_of_views(left: Picture, fused: Picture) -> Picture:
    """Edges of one view in red beside those of the fused picture in green, yellow where both are (figure 5.12).

    Parameters
    ----------
    left, fused : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)

    Returns
    -------
    ndarray of uint8, shape (rows, columns, 3)
    """
    alone, together = (boundaries_of_interest(one, hot_mask(one), "forest").band for one in (left, fused))
    shown = _colour(grey(left)) // 3
    shown[..., 1] = np.maximum(shown[..., 1], 255 * together)
    shown[..., 2] = np.maximum(shown[..., 2], 255 * alone)
    return shown


def _polygon(picture: Picture, points: Array, colour: Colour) -> None:
    cv2.polylines(picture, [np.rint(points).astype(np.int32)], isClosed=True, color=colour)


def _colour(picture: Picture) -> Picture:
    return picture.copy() if picture.ndim == 3 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR), np.uint8)
