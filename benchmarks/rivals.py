"""What the gauge computes, each beside what a user would pick instead.

Every function yields rows of the table. Rivals: a plain port of the dissertation (`plain_port.py`), OpenCV's structured
forest with the same model, numpy's and PyWavelets' plain fusion, a whole picture's threshold with scikit-image's SSIM.
"""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pywt
from ingot_rival import ingot_pictures, whole_picture
from mill_scenes import perfect_rig
from opencv_format import write_opencv
from pair import BARS_MM, rig_with_marks
from timing import Child, Row, in_turn, timed

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.boards.boards import Board, high_pose, low_pose
from appliance.simulation.true_rig import default_rig
from vision.alignment.view_alignment import Alignment
from vision.alignment.virtual_boards import VirtualBoards
from vision.edges.forest.inference import EdgeDetector
from vision.edges.forest.model import shipped_forest
from vision.fusion.methods import fuse
from vision.geometry.turned_region import whole_picture as whole_region
from vision.sizing.gauge import Gauge

SMALL, FULL = (800, 600), (2704, 1520)
LEVELS = 4


def gauge(size: tuple[int, int], folder: Path, rounds: int) -> Iterator[Row]:
    """Both routes with their judgement, beside the plain port of the dissertation, on the same pairs."""
    true_rig = default_rig(size)
    scene = Scene(true_rig, seed=1)
    pairs = [scene.pair(Bar(diameter_mm), 0) for diameter_mm in BARS_MM]
    files = [folder / f"{size[0]}_{number}.npz" for number in range(len(pairs))]
    for file, (left, right) in zip(files, pairs, strict=True):
        np.savez(file, left=left, right=right)
    np.savez(folder / "rig.npz", **boards_of(scene))
    write_opencv(shipped_forest(), folder / "forest.yml")
    measure = Gauge(rig_with_marks(scene, true_rig)).measure
    with Child("plain_port.py", folder / "forest.yml", folder / "rig.npz") as port:
        yield in_turn(
            f"a pair, both routes, {size[0]} x {size[1]}",
            "plain port of the dissertation",
            lambda number: timed(measure, *pairs[number % len(pairs)]),
            lambda number: port.ask(files[number % len(files)]),
            rounds,
        )


def boards_of(scene: Scene) -> dict[str, np.ndarray | float]:
    """Corners of the low and the high board in both views, as the plain port reads them."""
    board = Board()
    rig: dict[str, np.ndarray | float] = {"board_mm": board.corners_mm()[:, :2]}
    for name, pose in (("low", low_pose(board)), ("high", high_pose(board))):
        corners_mm = pose.in_world(board.corners_mm())
        rig |= {f"{side}_{name}": getattr(scene, side).camera.project(corners_mm) for side in ("left", "right")}
    return rig


def forest(size: tuple[int, int], folder: Path, rounds: int) -> Iterator[Row]:
    """Edges of a whole colour picture, two threads each."""
    left, _ = Scene(default_rig(size), seed=1).pair(Bar(180.0), 0)
    colour = np.ascontiguousarray(left[:, :, ::-1]).astype(np.float32) / np.float32(255)
    file = folder / "picture.npy"
    np.save(file, colour)
    write_opencv(shipped_forest(), folder / "forest.yml")
    detector = EdgeDetector(shipped_forest(), 2)
    with Child("opencv_forest.py", folder / "forest.yml") as opencv:
        yield in_turn(
            f"edges of a picture, {size[0]} x {size[1]}",
            "OpenCV's forest, same model",
            lambda _: timed(detector.strength_in, colour, [np.s_[:, :]]),
            lambda _: opencv.ask(f"2 {file}"),
            rounds,
        )


def fusion(size: tuple[int, int], _folder: Path, rounds: int) -> Iterator[Row]:
    """One grey pair, fused as algorithm 14 and by db4 wavelets."""
    pair = aligned_pair(size)
    with ThreadPoolExecutor(2) as pool:
        for method, rival, plain in (("fft", "numpy.fft", plain_fft), ("db4", "PyWavelets", plain_wavelets)):
            ours = partial(fuse, method=method, executor=pool)
            yield in_turn(
                f"{method} fusion of a pair, {size[0]} x {size[1]}",
                rival,
                lambda _, ours=ours: timed(ours, *pair),
                lambda _, plain=plain: timed(plain, *pair),
                rounds,
            )


def aligned_pair(size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Red channels of a pair, the right one warped on the left one at the bar's height."""
    true_rig = default_rig(size)
    rig = perfect_rig(true_rig)
    pictures = Scene(true_rig, seed=1).pair(Bar(180.0), 0)
    views = [
        whole_region(camera, np.ascontiguousarray(picture[:, :, 2]))
        for camera, picture in zip((rig.left, rig.right), pictures, strict=True)
    ]
    alignment = Alignment(rig, VirtualBoards.of_rig(rig), *views, projective=True)
    return alignment.left.picture, alignment.right_on_left(100.0)


def plain_fft(left, right):
    first, second = np.fft.fft2(left), np.fft.fft2(right)
    fused = np.where(np.abs(first) > np.abs(second), first, second)
    return np.clip(np.fft.ifft2(fused).real, 0, 255).astype(np.uint8)


def plain_wavelets(left, right):
    first, second = (pywt.wavedec2(picture, "db4", level=LEVELS) for picture in (left, right))
    fused = [(first[0] + second[0]) / 2]
    for bands, others in zip(first[1:], second[1:], strict=True):
        fused.append(tuple(np.where(np.abs(a) > np.abs(b), a, b) for a, b in zip(bands, others, strict=True)))
    rows, columns = left.shape
    return np.clip(pywt.waverec2(fused, "db4")[:rows, :columns], 0, 255).astype(np.uint8)


def ingot(_folder: Path, rounds: int) -> Iterator[Row]:
    """One picture with an ingot's end, on one core."""
    reader, references, pictures = ingot_pictures(rounds)
    height, width = pictures[0].shape[:2]
    yield in_turn(
        f"an ingot picture, {width} x {height}, one core",
        "threshold and two SSIM",
        lambda number: timed(reader.read, pictures[number]),
        lambda number: timed(whole_picture, pictures[number], references),
        len(pictures),
    )
