"""A folder with everything that a person hands to the commands, all of it small and right, to be spoilt by tests."""

import atexit
import functools
import json
import random
import shutil
import tempfile
from pathlib import Path

import cv2
import numpy as np
from drawn_ingots import CENTROID, CROP, ingot, line

from appliance.history import database
from appliance.history.tables import Row
from appliance.simulation.video_coding import Video
from appliance.simulation.write_recording import write_scene
from appliance.sizing.stereo.calibrate_folder import calibrate_folder
from appliance.sizing.stereo.gauge import rig_file_gauge
from appliance.sizing.stereo.rig_file import save_rig

SIDES = ("left", "right")
SCENE = "bar"
HISTORY_FROM_MS = 1_795_900_000_000  # 2026-11-28T21:06:40Z
GAUGE = """\
[plc]
port = 5031
writes = "all"
[sizing]
rig = "rig.json"
ovality_mm = 0.4
[sizing.camera]
kind = "recording"
path = "bar"
rate_hz = 20.0
[sizing.set_points]
target_mm = 250.0
tolerance_plus_mm = 1.0
tolerance_minus_mm = 1.0
grade = "C45"
temperature_c = 1050.0
"""


@functools.lru_cache(maxsize=1)
def workshop() -> Path:
    """The folder, made once in a process; read only."""
    folder = Path(tempfile.mkdtemp(prefix="workshop"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    write_scene(folder / "mill", "clean", 3, 1, poses=7)
    save_rig(calibrate_folder(folder / "mill").rig, folder / "rig.json")
    rig_file_gauge(folder / "rig.json", None).warm_up()  # what is compiled now delays no case
    (folder / "mill" / "scenes" / "clean").rename(folder / SCENE)
    pictures = {side: cv2.imread(str(folder / SCENE / side / "000000.png")) for side in SIDES}
    (folder / "video").mkdir()
    for side, picture in pictures.items():
        (folder / "jpegs" / side).mkdir(parents=True)
        cv2.imwrite(str(folder / "jpegs" / side / "000000.jpg"), picture, [cv2.IMWRITE_JPEG_QUALITY, 95])
        (folder / "video" / f"{side}.mp4").write_bytes(Video(18).encoded([picture] * 2))
    (folder / "jpegs" / "timestamps.csv").write_text("frame,left_us,right_us\n0,1000,1002\n")
    (folder / "jpegs" / "coding.json").write_text('{"bits": 12, "mosaic": "RGGB"}')
    _write_ends(folder)
    (folder / "gauge.toml").write_text(GAUGE)
    cells = [f"{bar},{day},{100 + bar + 0.01 * day + 0.001 * n}" for bar in (1, 2, 3) for day in (1, 2) for n in (1, 2)]
    (folder / "study.csv").write_text("\n".join(["bar,condition,diameter_mm", *cells]) + "\n")
    (folder / "set_points.json").write_text('{"target_diameter": 26550, "product_id": 305419896, "hold": true}')
    _write_readings(folder)
    _write_history(folder)
    return folder


def _write_readings(folder: Path) -> None:
    diameter_mm = float(json.loads((folder / SCENE / "truth.json").read_text())["diameter_mm"])
    row = {"frame": 0, "diameter_mm": diameter_mm + 0.1, "expanded_uncertainty_mm": 0.4, "valid": True, "reasons": []}
    (folder / "readings.jsonl").write_text(json.dumps(row) + "\n")


def _write_history(folder: Path) -> None:
    connection = database.open_to_write(folder / "history" / database.FILE_NAME)
    run = {"run_utc_ms": HISTORY_FROM_MS, "valid": 1, "diameter_mm": 250.0}
    rows = [run | {"exposed_utc_ms": HISTORY_FROM_MS + 60_000 * n, "sequence": n} for n in range(60)]
    database.write(connection, [Row("readings", row) for row in rows])
    connection.close()
    (folder / "history.toml").write_text('[history]\ndirectory = "history"\n')


def _write_ends(folder: Path) -> None:
    for name in ("ends", "references"):
        (folder / name).mkdir()
    for frame in range(4):
        picture = ingot(line(), y=250.0 + 3 * frame) if frame else line()
        cv2.imwrite(str(folder / "ends" / f"{frame:06d}.png"), picture)
    chance = np.random.default_rng(1)
    for name in ("top", "bottom"):
        grey = cv2.GaussianBlur(chance.integers(0, 255, (64, 64, 3), np.uint8), (0, 0), 2.0 if name == "top" else 9.0)
        cv2.imwrite(str(folder / "references" / f"{name}.png"), grey)
    regions = {"roi_crop": list(CROP), "roi_centroid": list(CENTROID)}
    (folder / "references" / "roi.json").write_text(json.dumps(regions))


def true_diameter_mm() -> float:
    """Diameter of the bar in all recordings of the folder."""
    return float(json.loads((workshop() / SCENE / "truth.json").read_text())["diameter_mm"])


def copied(to: Path, parts: list[str]) -> Path:
    """A copy of some parts of the folder, or of all but the board pictures, in a folder that is made."""
    source = workshop()
    to.mkdir()
    for part in dict.fromkeys(parts or (path.name for path in source.iterdir() if path.name != "mill")):
        target = to / part
        target.parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if (source / part).is_dir() else shutil.copyfile)(source / part, target)
    return to


def chance_of(kind: str, seed: int) -> random.Random:
    """Random numbers of one case."""
    return random.Random(f"{kind} {seed}")
