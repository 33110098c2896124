"""`hotgauge fuse`: fuses a pair, aligned on the plane where the bar's outlines agree, and computes its metrics."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from appliance.cameras.recording.picture_file import read_picture
from appliance.errors import HotgaugeError
from appliance.files.atomic_file import whole_place
from appliance.sizing.stereo.overlays import edges_of_views
from appliance.sizing.stereo.rig_file import RigError, load_rig
from vision.alignment.view_alignment import Alignment
from vision.alignment.virtual_boards import LEVEL, VirtualBoards
from vision.calibration.rig import Rig
from vision.fusion.common_view import common_rectangle
from vision.fusion.methods import MULTISCALE, Method, fuse
from vision.fusion.metrics import METRICS, PRINTED_METRICS
from vision.fusion.multiscale import DEFAULT_SCALES, Approximation, Scales
from vision.fusion.rules import Rule
from vision.geometry.turned_region import whole_picture
from vision.pictures import Picture, grey
from vision.reasons import REASONS
from vision.sent_picture import SentPicture
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

SUFFIXES = (".png", ".jpg", ".jpeg")


class FusionError(HotgaugeError):
    """A pair cannot be fused; the message says what, where and what to do."""


@dataclass(frozen=True, slots=True, eq=False)
class FusedPair:
    """A fused picture and the two views that it was made of.

    Attributes
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
    left, right : ndarray of uint8, same shape
        The views on the left camera's pixel grid, without lens distortion; what the right camera does not see is filled
        with the left view.
    common : tuple of two slice
        Rows and columns of the largest rectangle that both cameras see.
    seen_share : float
        Share of the left view's pixels that both cameras see.
    height_mm : float
        Height over the conveyor of the plane on which they are aligned.
    """

    picture: Picture
    left: Picture
    right: Picture
    common: tuple[slice, slice]
    seen_share: float
    height_mm: float


class Plane(NamedTuple):
    """Plane on which the views are aligned.

    Attributes
    ----------
    height_mm : float or None
        Over the conveyor, at x = y = 0; None: where the bar's outlines in both views agree.
    slope : tuple of float
        Rise in x and in y, mm per mm: the virtual board is turned so.
    """

    height_mm: float | None
    slope: tuple[float, float] = LEVEL


def checked_scales(
    method: Method, levels: int | None, rule: Rule | None, approximation: Approximation | None
) -> Scales:
    """Scales of the command line; None takes the default.

    Parameters
    ----------
    method : str
        One of `METHODS`.
    levels : int or None
        Levels of the decomposition, from 1.
    rule : str or None
        Choice between two details.
    approximation : str or None
        Choice between two approximations of the last level.

    Raises
    ------
    FusionError
        The method has no scales, or a value is out of bounds.
    """
    if (levels, rule, approximation) != (None, None, None) and method not in MULTISCALE:
        raise FusionError(f"--method: {method} has neither levels nor rules; {', '.join(MULTISCALE)} have")
    usual = DEFAULT_SCALES
    try:
        return Scales(
            usual.levels if levels is None else levels, rule or usual.rule, approximation or usual.approximation
        )
    except ValueError as error:
        raise FusionError(f"--{error}; levels count from 1") from error


def fuse_files(
    left: Path,
    right: Path,
    rig: Path,
    method: Method,
    *,
    scales: Scales = DEFAULT_SCALES,
    plane: Plane,
    periodic: bool = False,
) -> FusedPair:
    """Fuse the pictures of two files.

    Parameters
    ----------
    left, right : Path
        PNG or JPEG.
    rig : Path
        Calibration from `hotgauge calibrate`.
    method : str
        One of `METHODS`.
    scales : Scales
        Used by wavelets and the pyramid only.
    plane : Plane
        Plane on which the views are aligned.
    periodic : bool
        Of "fft"; see `vision.fusion.methods.fuse`.

    Raises
    ------
    CameraError
        A picture cannot be read.
    RigError
        The rig cannot be read, has no world frame, or is for pictures of another size.
    FusionError
        One picture is grey and the other in colour, or the bar's outlines agree on no plane.
    """
    calibrated = load_rig(rig)
    if not calibrated.has_world:
        raise RigError(f"{rig}: has no world frame; calibrate with the registration pictures of the low board")
    pictures = read_picture(left), read_picture(right)
    for picture, camera, path in zip(pictures, (calibrated.left, calibrated.right), (left, right), strict=True):
        size = picture.size
        if size != camera.image_size:
            expected = f"{camera.image_size[0]} x {camera.image_size[1]}"
            raise RigError(f"{rig}: made for pictures of {expected}, {path} is {size[0]} x {size[1]}; use its own rig")
    if pictures[0].shown.ndim != pictures[1].shown.ndim:
        raise FusionError(f"{right}: one picture is grey and the other in colour; give two of a kind")
    return _fused(pictures, calibrated, plane, partial(fuse, method=method, scales=scales, periodic=periodic))


def _fused(
    pictures: tuple[SentPicture, SentPicture], rig: Rig, plane: Plane, in_one: Callable[[Picture, Picture], Picture]
) -> FusedPair:
    height_mm = _height_of_bar(pictures, rig) if plane.height_mm is None else plane.height_mm
    left, right = map(whole_picture, (rig.left, rig.right), pictures)
    alignment = Alignment(rig, VirtualBoards.of_rig(rig), left, right, projective=True, slope=plane.slope)
    aligned, seen = alignment.right_on_left(height_mm), alignment.seen_by_both(height_mm)
    common = common_rectangle(seen)
    if not seen[common].size:
        raise FusionError(f"--height: on the plane at {height_mm:g} mm the views share nothing; give another height")
    return FusedPair(in_one(left.picture, aligned), left.picture, aligned, common, float(seen.mean()), height_mm)


def _height_of_bar(pictures: tuple[SentPicture, SentPicture], rig: Rig) -> float:
    # Sobel suffices: each point moves to the half level of light, independent of the edge detector
    reading = VirtualBoardGauge(rig, edges="sobel").measure(*pictures)
    if not math.isfinite(reading.plane_height_mm):
        text = "; ".join(row.text for row in REASONS if row.flag in reading.reasons)
        raise FusionError(f"no plane on which the outlines of a bar agree: {text}; give one with --height")
    return reading.plane_height_mm


def metric_lines(pair: FusedPair, *, as_printed: bool = False) -> list[str]:
    """Table of the metrics of the fused picture and of both views, in grey, where both cameras see the scene.

    Parameters
    ----------
    pair : FusedPair
    as_printed : bool
        Add the three that are defined otherwise than the dissertation prints them, as it prints them.
    """
    fused, left, right = (grey(picture)[pair.common] for picture in (pair.picture, pair.left, pair.right))
    lines = [f"{'':8}{'left':>10}{'right':>10}{'fused':>10}  better"]
    for row in (*METRICS, *(PRINTED_METRICS if as_printed else ())):
        views = [f"{row.of_one(view):10.4f}" if row.of_one else f"{'-':>10}" for view in (left, right)]
        better = "larger" if row.larger_is_better else "smaller"
        lines.append(f"{row.symbol:8}{''.join(views)}{row.measure(fused, left, right):10.4f}  {better:8} {row.text}")
    return lines


def write_picture(path: Path, picture: Picture) -> None:
    """Write a picture as PNG or JPEG.

    Parameters
    ----------
    path : Path
        Its suffix gives the format.
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)

    Raises
    ------
    FusionError
        The suffix is neither PNG's nor JPEG's.
    OSError
        The file cannot be written.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise FusionError(f"{path}: is neither PNG nor JPEG; let its name end in {', '.join(SUFFIXES)}")
    _, data = cv2.imencode(path.suffix.lower(), picture)
    with whole_place(path) as place:
        place.write_bytes(data.tobytes())


def write_plots(folder: Path, pair: FusedPair) -> None:
    """Write `left.png`, `right_aligned.png`, `pair.png` (left red, right cyan) and `edges.png`; raises `OSError`.

    Parameters
    ----------
    folder : Path
        Made if it is missing.
    pair : FusedPair
    """
    folder.mkdir(parents=True, exist_ok=True)
    left, right = grey(pair.left), grey(pair.right)
    pictures = {
        "left": pair.left,
        "right_aligned": pair.right,
        "pair": np.dstack([right, right, left]),
        "edges": edges_of_views(pair.left, pair.picture),
    }
    for name, picture in pictures.items():
        write_picture(folder / f"{name}.png", picture)
