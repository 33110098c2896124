"""An alarm writes the pictures that led to it, and `hotgauge measure` on them gives the bits that were served."""

import contextlib
import hashlib
import json
import math
import sqlite3
import subprocess
import sys
from pathlib import Path

import cv2
import pytest
from modbus_wire import eventually, write_coils, write_registers
from plc_view import has_value, look, wait_for
from rehearsal import rehearsing

from appliance.black_box.settings import BlackBoxSettings
from appliance.cameras.recording.settings import RecordingCamera
from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.cameras.simulated.settings import MillCamera
from appliance.history import database
from appliance.sizing.adjustment import Adjustment
from appliance.sizing.stereo.rig_file import save_rig
from appliance.sizing.stereo.settings import SizingSettings
from plc.registers import SET_POINTS

pytestmark = pytest.mark.waiting

SIDES = ("left", "right")
COUNT = 8
HISTORY_NOT_WRITTEN = 1 << 29


@pytest.fixture(scope="module")
def recorded(tmp_path_factory) -> Path:
    """A rig and a recording of JPEG pictures, whose luma is measured."""
    folder = tmp_path_factory.mktemp("recorded")
    save_rig(mill_rig(MillSource(seed=1, rate_hz=0)), folder / "rig.json")
    with MillSource(seed=1, rate_hz=0) as source:
        for number in range(COUNT):
            pair = source.next(10)
            for side, picture in zip(SIDES, (pair.left, pair.right), strict=True):
                (folder / side).mkdir(exist_ok=True)
                cv2.imwrite(str(folder / side / f"{number:06d}.jpg"), picture)
    return folder


def measured(recording: Path, output: Path) -> list[dict]:
    arguments = [sys.executable, "-m", "appliance", "measure", str(recording), "--output", str(output)]
    subprocess.run(arguments, check=True, capture_output=True)
    return rows_of(output)


def rows_of(file: Path) -> list[dict]:
    return [json.loads(line) for line in file.read_text().splitlines()]


def assert_same_bits(again: list[dict], kept: list[dict]) -> None:
    assert len(again) == len(kept) > 3
    for one, other in zip(again, kept, strict=True):
        for name in one.keys() - {"elapsed_ms"}:
            assert one[name] == other[name], name


def served(history: Path) -> dict[int, tuple[float, ...]]:
    columns = "exposed_utc_ms, diameter_mm, expanded_uncertainty_mm, weighted_deviation_mm, plane_height_mm"
    with contextlib.closing(sqlite3.connect(history / database.FILE_NAME)) as connection:
        rows = connection.execute(f"SELECT {columns} FROM readings WHERE valid").fetchall()
    return {row[0]: row[1:] for row in rows}


def test_an_alarm_keeps_pictures_that_measure_to_the_bits_that_were_served(recorded, tmp_path, monkeypatch):
    boxes, history = tmp_path / "boxes", tmp_path / "history"
    digest = hashlib.sha256((recorded / "rig.json").read_bytes()).hexdigest()
    decided = {"date": "2026-11-28", "reason": "master", "who": "A. Smith", "calibration_sha256": digest}
    sizing = SizingSettings(
        camera=RecordingCamera(kind="recording", path=recorded, rate_hz=4.0),
        rig=recorded / "rig.json",
        ovality_mm=0.7,
        adjustment=Adjustment(added_mm=0.3, expanded_mm=0.05, **decided),
        black_box=BlackBoxSettings(directory=boxes, seconds=3.0),
        stale_after_ms=5000,
    )
    with rehearsing("appliance.sizing.station", tmp_path, monkeypatch, sizing) as rehearsal:
        rehearsal.keep_in(None, history)
        rehearsal.start()
        with rehearsal.connect(within_s=90) as wire:  # a real station, which compiles
            seen = wait_for(wire, has_value, 60)
            wait_for(wire, lambda now: (now["sequence"] - seen["sequence"]) & 0xFFFF > 12, 30)
            wire.ask(write_registers(SET_POINTS.start, 30000, 200, 200))  # a target that no bar here has
            assert eventually(lambda: len(list(boxes.glob("2*out_of_tolerance"))) == 1, 90)
            fault_word = look(wire)["fault_word"]
    assert not fault_word & HISTORY_NOT_WRITTEN
    (box,) = boxes.glob("2*out_of_tolerance")
    kept = rows_of(box / "readings.jsonl")
    assert_same_bits(measured(box, tmp_path / "again.jsonl"), kept)
    assert any(row["weighted_deviation_mm"] for row in kept)
    assert all("adjusted" in row["reasons"] for row in kept if row["valid"])
    assert all(row["u_shape_mm"] > 0 for row in kept if row["valid"])  # ovality is in the settings that it brings
    values = served(history)
    compared = 0
    for row in kept:
        if row["exposed_utc_ms"] in values:
            names = ("diameter_mm", "expanded_uncertainty_mm", "weighted_deviation_mm", "plane_height_mm")
            told = tuple(math.nan if row[name] is None else row[name] for name in names)
            assert values[row["exposed_utc_ms"]] == told
            compared += 1
    assert compared > 3


def test_the_plc_asks_for_pictures_and_the_mill_s_own_rig_comes_with_them(tmp_path, monkeypatch):
    boxes = tmp_path / "boxes"
    sizing = SizingSettings(
        camera=MillCamera(rate_hz=4.0), black_box=BlackBoxSettings(directory=boxes, seconds=2.5), stale_after_ms=5000
    )
    with rehearsing("appliance.sizing.station", tmp_path, monkeypatch, sizing) as rehearsal:
        rehearsal.start()
        with rehearsal.connect(within_s=90) as wire:  # a real station, which compiles
            seen = wait_for(wire, has_value, 90)
            wait_for(wire, lambda now: (now["sequence"] - seen["sequence"]) & 0xFFFF > 6, 30)
            wire.ask(write_coils(42, True))
            assert eventually(lambda: len(list(boxes.glob("2*request"))) == 1, 90)
    (box,) = boxes.glob("2*request")
    assert_same_bits(measured(box, tmp_path / "again.jsonl"), rows_of(box / "readings.jsonl"))


def test_pictures_that_cannot_be_kept_are_a_fault_and_measuring_goes_on(recorded, tmp_path, monkeypatch):
    place = tmp_path / "boxes"
    place.write_text("a file where the folder should be")
    sizing = SizingSettings(
        camera=RecordingCamera(kind="recording", path=recorded, rate_hz=4.0),
        rig=recorded / "rig.json",
        black_box=BlackBoxSettings(directory=place, seconds=3.0),
        stale_after_ms=5000,
    )
    with rehearsing("appliance.sizing.station", tmp_path, monkeypatch, sizing) as rehearsal:
        rehearsal.start()
        with rehearsal.connect(within_s=90) as wire:  # a real station, which compiles
            wait_for(wire, has_value, 60)
            wire.ask(write_coils(42, True))
            assert wait_for(wire, lambda now: now["fault_word"] & HISTORY_NOT_WRITTEN, 30)
            assert has_value(look(wire))
