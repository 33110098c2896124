"""A recording of the simulated mill on disk: rig folder, pictures and truth, laid out for a stranger's use."""

import json
import os
import shutil
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np

from appliance.mill.bars import bar_at, truth
from appliance.mill.board_pictures import rig_folder_pictures
from appliance.mill.boards import Board, board_document
from appliance.mill.rig import TrueRig, default_rig
from appliance.mill.scene import Picture, Scene
from appliance.mill.sensor import Sensor
from appliance.mill.thermal import ThermalLine, thermal_truth

JPEG_OPTIONS = [
    cv2.IMWRITE_JPEG_QUALITY,
    95,
    # Halved chroma would move the red edges inwards by 0.05 to 0.09 px.
    cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
    cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
]
SIDES = ("left", "right")


class OutputError(Exception):
    """The recording cannot be written; the message says what, where and what to do."""


def write_recording(
    directory: Path,
    seed: int,
    frames: int,
    *,
    scene_name: str = "s1_clean",
    poses: int = 15,
    on_progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write a rig folder and one recorded scene with its truth; all of it or nothing.

    `directory` then holds `calibration/`, `registration/`, `board.json`, `truth_rig.json` and
    `scenes/<scene_name>/` with `left/`, `right/` (JPEG, 4:4:4) and `truth.json`.

    Parameters
    ----------
    directory : Path
        Missing or empty.
    seed : int
        Bars, background, boards and noise.
    frames : int
        Number of image pairs, the first of the line with this seed.
    scene_name : str
        Folder of the scene.
    poses : int
        Board poses for the calibration of the cameras.
    on_progress : callable
        Called with the number of image pairs written so far and their total.

    Raises
    ------
    OutputError
        `directory` is not empty or cannot be written.
    """
    with _whole(directory) as folder:
        _Writer(folder, seed, frames, poses, on_progress).write(scene_name)


def write_thermal_recording(directory: Path, line: ThermalLine, *, empty: int = 5, frames: int = 10) -> None:
    """Write a recording of one thermal camera, `000000.png` ... and `truth.json`; all of it or nothing.

    Parameters
    ----------
    directory : Path
        Missing or empty.
    line : ThermalLine
    empty : int
        Frames without the bar at the beginning.
    frames : int
        Frames with the bar after them.

    Raises
    ------
    OutputError
        `directory` is not empty or cannot be written.
    """
    with _whole(directory) as folder:
        for number, picture in enumerate(line.pictures(empty, frames)):
            (folder / f"{number:06}.png").write_bytes(cv2.imencode(".png", picture)[1].tobytes())
        _write_json(folder / "truth.json", thermal_truth(line, empty, frames))


@contextmanager
def _whole(directory: Path) -> Generator[Path, None, None]:
    """A folder that becomes `directory` when all has been written to it."""
    place = directory.resolve()
    partial = place.with_name(f".{place.name}.partial-{os.getpid()}")
    try:
        if directory.exists() and any(directory.iterdir()):
            raise OutputError(f"{directory}: is not empty; give a new or empty folder")
        partial.mkdir(parents=True)
        yield partial
        partial.replace(place)
    except OSError as error:
        raise OutputError(
            f"{directory}: cannot be written ({error.strerror}); check path, permissions and free space"
        ) from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)


class _Writer:
    def __init__(
        self, folder: Path, seed: int, frames: int, poses: int, on_progress: Callable[[int, int], None] | None
    ) -> None:
        self._folder = folder
        self._seed = seed
        self._frames = frames
        self._poses = poses
        self._rng = np.random.default_rng([seed, 0x7772])
        self._board = Board.with_errors(self._rng)
        self._rig = default_rig()
        self._sensor = Sensor()
        self._done = 0
        self._total = frames + poses + 2
        self._on_progress = on_progress

    def write(self, scene_name: str) -> None:
        scene = Scene(self._rig, self._seed, self._sensor)
        _write_json(self._folder / "board.json", board_document(self._board, self._sensor.response))
        _write_json(self._folder / "truth_rig.json", _rig_document(self._rig, self._board))
        for path, left, right in rig_folder_pictures(scene, self._rig, self._rng, self._board, self._poses):
            self._write_pair(path, left, right)
        self._write_scene(scene, f"scenes/{scene_name}")

    def _write_scene(self, scene: Scene, place: str) -> None:
        rows: list[dict[str, object]] = []
        for frame in range(self._frames):
            bar = bar_at(self._seed, frame)
            self._write_pair(f"{place}/{{side}}/{frame:06}.jpg", *scene.pair(bar, frame))
            rows.append({"frame": f"{frame:06}", **truth(bar, self._rig.region_y_mm)})
        _write_json(self._folder / f"{place}/truth.json", _scene_document(rows))

    def _write_pair(self, place: str, left: Picture, right: Picture) -> None:
        for side, picture in zip(SIDES, (left, right), strict=True):
            path = self._folder / place.format(side=side)
            path.parent.mkdir(parents=True, exist_ok=True)
            options = JPEG_OPTIONS if path.suffix == ".jpg" else []
            path.write_bytes(cv2.imencode(path.suffix, picture, options)[1].tobytes())
        self._done += 1
        if self._on_progress is not None:
            self._on_progress(self._done, self._total)


def _write_json(path: Path, document: dict[str, object]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def _scene_document(rows: list[dict[str, object]]) -> dict[str, object]:
    """`truth.json`: what all frames share on top, None where they differ."""

    def shared(key: str) -> object:
        values = [row.get(key) for row in rows]
        return values[0] if values and all(value == values[0] for value in values) else None

    return {
        "diameter_mm": shared("diameter_mm"),
        "temperature_c": shared("temperature_c"),
        "condition": "clean",
        "visible_in": list(SIDES),
        "occluded_in": [],
        "frames": rows,
    }


def _rig_document(rig: TrueRig, board: Board) -> dict[str, object]:
    """`truth_rig.json`: for judging, never for measuring."""
    return {
        "image_size": list(rig.left.image_size),
        "units": "mm",
        "world": "z up, roller tops z = 0, bar axis about +y, x across; OpenCV cameras, x_cam = R x_world + t",
        "cameras": {
            side: {name: getattr(camera, name).tolist() for name in ("K", "dist", "R", "t")}
            for side, camera in zip(SIDES, rig.cameras, strict=True)
        },
        "board": {
            "squares": list(board.squares),
            "inner_corners": [count - 1 for count in board.squares],
            "square_mm": board.true_square_mm,
        },
        "registration": {"board_centre_xy_mm": [0.0, 0.0], "board_yaw_deg": 0.0},
        "low_mm": board.low_mm + board.low_error_mm,
        "high_mm": board.high_mm + board.high_error_mm,
        "measure_y_mm": list(rig.region_y_mm),
    }
