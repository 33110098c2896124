"""A recording of the simulated mill on disk: rig folder, pictures and truth, laid out for a stranger's use."""

import csv
import itertools
import json
import os
import shutil
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np

from appliance.errors import HotgaugeError
from appliance.simulation.bars.bars import bar_at, truth
from appliance.simulation.bars.line_scene import Picture, Scene
from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.boards.board_pictures import rig_folder_pictures
from appliance.simulation.boards.boards import Board, board_document
from appliance.simulation.ingots.conditions import ingot_sequence
from appliance.simulation.ingots.truth import Truth
from appliance.simulation.sensor import Sensor
from appliance.simulation.thermal_line import ThermalLine, thermal_truth
from appliance.simulation.true_rig import TrueRig, default_rig

JPEG_OPTIONS = [
    cv2.IMWRITE_JPEG_QUALITY,
    95,
    # Halved chroma would move the red edges inwards by 0.05 to 0.09 px.
    cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
    cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
]
SIDES = ("left", "right")


class OutputError(HotgaugeError):
    """The recording cannot be written; the message says what, where and what to do."""


def write_line(
    directory: Path, seed: int, frames: int, *, poses: int = 15, on_progress: Callable[[int, int], None] | None = None
) -> None:
    """Write the embedded line as a recording, with the rig folder of its cameras; all of it or nothing.

    `directory` then holds `calibration/`, `registration/`, `board.json`, `truth_rig.json` and `scenes/line/` with
    `left/`, `right/` (JPEG, 4:4:4) and `truth.json`.

    Parameters
    ----------
    directory : Path
        Missing or empty.
    seed : int
        Bars, background, boards and noise.
    frames : int
        Number of image pairs, the first of the line with this seed.
    poses : int
        Board poses for the calibration of the cameras.
    on_progress : callable
        Called with the number of image pairs written so far and their total.

    Raises
    ------
    OutputError
        `directory` is not empty or cannot be written.
    """
    sensor = Sensor()
    rig = default_rig()
    scene = Scene(rig, seed, sensor)

    def pairs() -> Iterator[_Frame]:
        for frame in range(frames):
            bar = bar_at(seed, frame)
            yield *scene.pair(bar, frame), truth(bar, rig.region_y_mm)

    with _whole(directory) as folder:
        writer = _Writer(folder, frames + poses + 2, on_progress)
        writer.write_rig_folder(scene, rig, sensor, seed, poses)
        writer.write_scene("line", pairs(), ".jpg", "as each frame says")


def write_scene(
    directory: Path,
    condition: str,
    seed: int,
    frames: int,
    *,
    effects: Sequence[str] = (),
    poses: int = 15,
    on_progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write one bar under a condition as a recording, with the rig folder of its cameras; all of it or nothing.

    The rig is drawn from the seed. As `write_line`, but in `scenes/<condition>/` and as PNG, so that a coding that
    is part of the scene stays as it is.

    Parameters
    ----------
    directory : Path
        Missing or empty.
    condition : str
        Of `CONDITIONS`.
    seed : int
        Rig, bar, background, boards and noise.
    frames : int
        Number of image pairs of the same bar, each with its own noise.
    effects : sequence of str
        Of `CONDITIONS`.
    poses : int
        Board poses for the calibration of the cameras.
    on_progress : callable
        Called with the number of image pairs written so far and their total.

    Raises
    ------
    ValueError
        `condition` or `effects` are not in the table.
    OutputError
        `directory` is not empty or cannot be written.
    """
    setup = set_up(condition, seed, effects=effects)
    told = setup.truth(condition, effects)
    with _whole(directory) as folder:
        writer = _Writer(folder, frames + poses + 2, on_progress)
        writer.write_rig_folder(setup.scene_as_calibrated(), setup.rig, setup.sensor, seed, poses)
        pairs = ((*setup.pair(frame), told) for frame in range(frames))
        writer.write_scene(condition, pairs, ".png", condition)


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


def write_ingots(
    directory: Path,
    condition: str,
    seed: int,
    frames: int,
    *,
    on_progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write an ingot line as a recording of one camera, with its references; all of it or nothing.

    `directory` then holds `top.png`, `bottom.png` and `roi.json`, for `hotgauge orient --references`, and `seq01/` with
    the pictures (JPEG) and `truth.csv`.

    Parameters
    ----------
    directory : Path
        Missing or empty.
    condition : str
        Of `INGOT_CONDITIONS`.
    seed : int
        Line, ingots, patterns, times and noise.
    frames : int
        Number of pictures, the first of the endless line with this seed.
    on_progress : callable
        Called with the number of pictures written so far and their total.

    Raises
    ------
    ValueError
        `condition` is not in the table.
    OutputError
        `directory` is not empty or cannot be written.
    """
    sequence = ingot_sequence(seed, condition, ingots=None)
    with _whole(directory) as folder:
        for label, square in sequence.references.items():
            (folder / f"{label}.png").write_bytes(cv2.imencode(".png", square)[1].tobytes())
        _write_json(folder / "roi.json", sequence.line.document())
        pictures = folder / "seq01"
        pictures.mkdir()
        with (pictures / "truth.csv").open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(Truth._fields)
            for jpeg, told in itertools.islice(sequence.jpeg_frames, frames):
                (pictures / f"{told.frame:06}.jpg").write_bytes(jpeg)
                table.writerow(told)
                if on_progress is not None:
                    on_progress(told.frame + 1, frames)


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


_Frame = tuple[Picture, Picture, dict[str, object]]


class _Writer:
    def __init__(self, folder: Path, total: int, on_progress: Callable[[int, int], None] | None) -> None:
        self._folder = folder
        self._done = 0
        self._total = total
        self._on_progress = on_progress

    def write_rig_folder(self, scene: Scene, rig: TrueRig, sensor: Sensor, seed: int, poses: int) -> None:
        rng = np.random.default_rng([seed, 0x7772])
        board = Board.with_errors(rng)
        _write_json(self._folder / "board.json", board_document(board, sensor.response))
        _write_json(self._folder / "truth_rig.json", _rig_document(rig, board))
        for path, left, right in rig_folder_pictures(scene, rig, rng, board, poses):
            self._write_pair(path, left, right)

    def write_scene(self, name: str, frames: Iterable[_Frame], suffix: str, condition: str) -> None:
        rows: list[dict[str, object]] = []
        for number, (left, right, told) in enumerate(frames):
            self._write_pair(f"scenes/{name}/{{side}}/{number:06}{suffix}", left, right)
            rows.append({"frame": f"{number:06}", **told})
        _write_json(self._folder / f"scenes/{name}/truth.json", _scene_document(rows, condition))

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


def _scene_document(rows: list[dict[str, object]], condition: str) -> dict[str, object]:
    """`truth.json`: what all frames share on top, None where they differ."""

    def shared(key: str) -> object:
        values = [row.get(key) for row in rows]
        return values[0] if values and all(value == values[0] for value in values) else None

    return {
        "diameter_mm": shared("diameter_mm"),
        "temperature_c": shared("temperature_c"),
        "condition": condition,
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
