"""What the black box keeps in memory and on disk: bounded, whole, and with the code values that were measured."""

import errno
import json
import time
from collections import deque, namedtuple
from pathlib import Path

import numpy as np
import pytest
from hanging_disk import HangingDisk
from modbus_wire import eventually

from appliance.black_box import black_box as box_module
from appliance.black_box.black_box import BlackBox
from appliance.black_box.picture_memory import KeptExposure, PictureMemory
from appliance.black_box.recording_folder import write_recording
from appliance.black_box.settings import BlackBoxSettings
from appliance.cameras.recording.pairs import Recording
from appliance.cameras.recording.pictures import PictureRecording
from appliance.cameras.source import CameraError, Frame, FramePair
from vision.sent_picture import LUMA_709, Coding, SentPicture, sent_picture

ROWS, COLUMNS = 40, 60
RNG = np.random.default_rng(5)


def colour(rows: int = ROWS) -> np.ndarray:
    return RNG.integers(0, 256, (rows, COLUMNS, 3), dtype=np.uint8)


def pair(number: int, moment_s: float = 0.0, *, rows: int = ROWS, sent=None) -> FramePair:
    left, right = (sent[0].shown, sent[1].shown) if sent else (colour(rows), colour(rows))
    return FramePair(
        left,
        right,
        sequence=number,
        left_us=1000 * number,
        right_us=1000 * number + 7,
        exposed_monotonic_s=moment_s,
        exposed_utc_ms=1_700_000_000_000 + number,
        sent=sent,
    )


def kept(exposed, **row) -> KeptExposure:
    return KeptExposure(exposed, lambda: [dict(row)])


PAIR_BYTES = 2 * ROWS * COLUMNS * 3


def test_memory_holds_no_more_than_its_seconds():
    memory = PictureMemory(2.0, 1 << 30)
    for number in range(50):
        memory.add(kept(pair(number, 0.1 * number)))
    moments = [one.exposed.exposed_monotonic_s for one in memory.all()]
    assert moments[-1] == pytest.approx(4.9)
    assert moments[0] == pytest.approx(2.9, abs=0.11)


def test_memory_holds_no_more_than_its_bytes_whatever_the_seconds():
    memory = PictureMemory(1000.0, 10 * PAIR_BYTES)
    for number in range(50):
        memory.add(kept(pair(number, 0.1 * number)))
    assert [one.exposed.sequence for one in memory.all()] == list(range(40, 50))


@pytest.mark.parametrize("again", [1, 3])
def test_one_exposure_that_is_larger_than_the_memory_is_not_kept_and_stops_nobody(again):
    memory = PictureMemory(1000.0, PAIR_BYTES - 1)
    for number in range(again):
        memory.add(kept(pair(number)))
    assert not memory.all()


def test_pictures_that_are_measured_in_other_codes_than_shown_count_twice_against_the_memory():
    luma = sent_picture(colour()[:, :, 0].copy(), Coding("luma"), colour())
    plain = SentPicture.of(colour())
    sizes = [kept(pair(0, sent=(one, one))).size_bytes for one in (plain, luma)]
    assert sizes == [PAIR_BYTES, PAIR_BYTES + 2 * ROWS * COLUMNS]


def test_a_picture_of_another_size_begins_a_new_memory():
    memory = PictureMemory(1000.0, 1 << 30)
    for number in range(3):
        memory.add(kept(pair(number)))
    memory.add(kept(pair(3, rows=50)))
    assert [one.exposed.sequence for one in memory.all()] == [3]


CODED = {
    "plain": [SentPicture.of(colour()), SentPicture.of(colour())],
    "grey": [SentPicture.of(colour()[:, :, 0].copy()), SentPicture.of(colour()[:, :, 0].copy())],
    "luma of video": [
        sent_picture(colour()[:, :, 0].copy(), Coding("luma", full_range=False, luma_weights=LUMA_709,
                                                       compression="video"), colour())
        for _ in range(2)
    ],
    "jpeg of two qualities": [SentPicture(one, one, Coding("colour", compression="jpeg", quality=quality))
                              for one, quality in ((colour(), 80), (colour(), 91))],
    "mosaic of 12 bits": [
        sent_picture(RNG.integers(0, 4096, (ROWS, COLUMNS), dtype=np.uint16), Coding("mosaic", 12, mosaic="GBRG"))
        for _ in range(2)
    ],
    "grey of 16 bits": [
        sent_picture(RNG.integers(0, 65536, (ROWS, COLUMNS), dtype=np.uint16), Coding("grey", 16)) for _ in range(2)
    ],
}  # fmt: skip


@pytest.mark.parametrize("name", CODED)
def test_a_recording_gives_back_every_code_value_and_coding_that_was_measured(tmp_path, name):
    left, right = CODED[name]
    exposures = deque([kept(pair(7, sent=(left, right))), kept(pair(8, sent=(right, left)))])
    write_recording(tmp_path / "box", exposures, {})
    read = list(Recording(tmp_path / "box"))
    assert [frame for frame, _, _ in read] == [0, 1]
    for (_, *got), wanted in zip(read, ((left, right), (right, left)), strict=True):
        for one, other in zip(got, wanted, strict=True):
            np.testing.assert_array_equal(one.shown, other.shown)
            np.testing.assert_array_equal(one.measured, other.measured)
            assert one.measured.dtype == other.measured.dtype
            assert one.coding == other.coding


def test_a_recording_whose_stored_codes_are_damaged_is_refused_by_name(tmp_path):
    write_recording(tmp_path / "box", deque([kept(pair(7, sent=tuple(CODED["luma of video"])))]), {})
    path = tmp_path / "box/measured/right/000000.png"
    path.write_bytes(b"no picture")
    with pytest.raises(CameraError, match=str(path)):
        list(Recording(tmp_path / "box"))


def test_a_recording_of_one_camera_is_a_folder_of_pictures(tmp_path):
    frames = [Frame(colour(), number, float(number), 1000 * number) for number in range(2)]
    write_recording(tmp_path / "box", deque([kept(one) for one in frames]), {"scale/empty.png": b"picture"})
    read = list(PictureRecording(tmp_path / "box"))
    for (number, picture), frame in zip(read, frames, strict=True):
        np.testing.assert_array_equal(picture.shown, frame.picture)
        assert number == frame.sequence


def test_memory_is_free_as_soon_as_a_recording_is_written(tmp_path):
    exposures = deque([kept(pair(0))])
    write_recording(tmp_path / "box", exposures, {})
    assert not exposures


@pytest.fixture
def boxes(monkeypatch):
    monkeypatch.setattr(box_module, "AFTER_S", 0.05)
    made: list[BlackBox] = []

    def make(directory: Path | None, **settings) -> BlackBox:
        made.append(BlackBox(BlackBoxSettings(directory=directory, **settings), "sizing"))
        made[-1].files = {"settings.json": b"{}"}
        return made[-1]

    yield make
    for box in made:
        box.close()


def recordings(folder: Path) -> list[Path]:
    return sorted(folder.glob("2*")) if folder.is_dir() else []


def fill(box: BlackBox, count: int = 3) -> None:
    for number in range(count):
        box.add(
            pair(number, time.monotonic()), lambda number=number: [{"frame": number, "diameter_mm": 100.0 + number}]
        )


def test_a_cause_writes_pictures_readings_time_stamps_and_what_measured_them(boxes, tmp_path):
    box = boxes(tmp_path / "box")
    fill(box)
    box.keep("alarm_low_trust")
    assert eventually(lambda: recordings(tmp_path / "box"), 5)
    (folder,) = recordings(tmp_path / "box")
    assert folder.name.endswith("Z-sizing-alarm_low_trust")
    assert len(list(Recording(folder))) == 3
    rows = [json.loads(line) for line in (folder / "readings.jsonl").read_text().splitlines()]
    assert [(row["frame"], row["sequence"], row["diameter_mm"]) for row in rows] == [(n, n, 100 + n) for n in range(3)]
    assert (folder / "timestamps.csv").read_text().splitlines()[2] == "1,1000,1007,0"
    told = json.loads((folder / "black_box.json").read_text())
    assert (told["why"], told["station"], told["carried"]) == (["alarm_low_trust"], "sizing", [])
    assert told["version"]
    assert (folder / "settings.json").read_bytes() == b"{}"


def test_what_follows_the_cause_is_in_the_recording_too(boxes, tmp_path, monkeypatch):
    monkeypatch.setattr(box_module, "AFTER_S", 0.5)
    box = boxes(tmp_path / "box")
    fill(box, 1)
    box.keep("request")
    time.sleep(0.1)
    box.add(pair(9, time.monotonic()), list)
    assert eventually(lambda: recordings(tmp_path / "box"), 5)
    assert len(list(Recording(recordings(tmp_path / "box")[0]))) == 2


def test_the_same_cause_writes_again_only_after_its_time_and_another_one_at_once(boxes, tmp_path):
    box = boxes(tmp_path / "box", again_after_s=3600)
    fill(box)
    box.keep("out_of_tolerance")
    assert eventually(lambda: len(recordings(tmp_path / "box")) == 1, 5)
    box.keep("out_of_tolerance")
    box.keep("alarm_camera")
    assert eventually(lambda: len(recordings(tmp_path / "box")) == 2, 5)
    time.sleep(0.2)
    names = {one.name.rpartition("-")[2] for one in recordings(tmp_path / "box")}
    assert names == {"alarm_camera", "out_of_tolerance"}


def test_causes_that_come_together_share_one_recording(boxes, tmp_path):
    box = boxes(tmp_path / "box")
    fill(box)
    for why in ("out_of_tolerance", "alarm_out_of_tolerance", "out_of_tolerance"):
        box.keep(why)
    assert eventually(lambda: recordings(tmp_path / "box"), 5)
    time.sleep(0.2)
    (folder,) = recordings(tmp_path / "box")
    told = json.loads((folder / "black_box.json").read_text())
    assert told["why"] == ["out_of_tolerance", "alarm_out_of_tolerance"]


def test_the_oldest_recordings_of_this_station_go_when_there_are_too_many(boxes, tmp_path):
    others = [tmp_path / "20000101T000000Z-ingot-request", *(tmp_path / f"2000010{n}T000000Z-sizing-a" for n in (1, 2))]
    for folder in others:
        folder.mkdir()
    box = boxes(tmp_path, recordings_max=2)
    fill(box)
    box.keep("request")
    assert eventually(lambda: not others[1].exists(), 5)
    assert others[0].exists()
    assert others[2].exists()
    assert len(recordings(tmp_path)) == 3


def test_the_oldest_recordings_go_when_they_are_too_large(boxes, tmp_path):
    old = tmp_path / "20000101T000000Z-sizing-a"
    old.mkdir()
    (old / "large").write_bytes(bytes(11 << 20))
    box = boxes(tmp_path, size_max_mb=10)
    fill(box)
    box.keep("request")
    assert eventually(lambda: not old.exists(), 5)
    assert len(recordings(tmp_path)) == 1


def test_what_an_end_left_half_written_is_removed(boxes, tmp_path):
    partial = tmp_path / ".partial-20000101T000000Z-sizing-a"
    partial.mkdir()
    boxes(tmp_path)
    assert eventually(lambda: not partial.exists(), 5)


def test_a_full_disk_is_told_and_leaves_nothing_half_written(boxes, tmp_path, monkeypatch):
    usage = namedtuple("usage", "free")
    monkeypatch.setattr(box_module.shutil, "disk_usage", lambda _: usage(100 << 20))
    box = boxes(tmp_path)
    fill(box)
    box.keep("request")
    assert eventually(lambda: "no space left" in box.trouble, 5)
    assert not list(tmp_path.iterdir())
    monkeypatch.setattr(box_module.shutil, "disk_usage", lambda _: usage(1 << 40))
    box.keep("alarm_camera")
    assert eventually(lambda: not box.trouble and recordings(tmp_path), 5)


def test_a_write_that_breaks_off_leaves_nothing_half_written(boxes, tmp_path, monkeypatch):
    def fails(_handle: int) -> None:
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr("appliance.black_box.recording_folder.os.fsync", fails)
    box = boxes(tmp_path)
    fill(box)
    box.keep("request")
    assert eventually(lambda: "Input/output error" in box.trouble, 5)
    assert not list(tmp_path.iterdir())


def test_a_box_that_may_not_lower_its_priority_writes_all_the_same(boxes, tmp_path, monkeypatch):
    def refuses(*_: int) -> None:
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(box_module.os, "setpriority", refuses)
    box = boxes(tmp_path)
    fill(box)
    box.keep("request")
    assert eventually(lambda: recordings(tmp_path), 5)


def test_a_mistake_while_writing_is_told_and_the_next_cause_is_written(boxes, tmp_path):
    box = boxes(tmp_path)

    def rows() -> list[dict]:
        raise KeyError("diameter_mm")

    box.add(pair(0, time.monotonic()), rows)
    box.keep("request")
    assert eventually(lambda: "KeyError('diameter_mm')" in box.trouble, 5)
    assert not list(tmp_path.iterdir())
    box._memory = PictureMemory(5.0, 1 << 30)
    fill(box)
    box.keep("alarm_camera")
    assert eventually(lambda: not box.trouble and recordings(tmp_path), 5)


def test_without_a_directory_nothing_is_kept_in_memory_and_no_thread_runs(boxes):
    box = boxes(None)
    fill(box)
    box.keep("request")
    assert box._thread is None
    assert not box._memory.all()


def test_adding_never_waits_while_a_recording_is_written(boxes, tmp_path, monkeypatch):
    disk = HangingDisk()
    monkeypatch.setattr("appliance.black_box.recording_folder.os.fsync", disk.hang)
    box = boxes(tmp_path)
    fill(box)
    box.keep("request")
    disk.wait_for_hanging()
    fill(box, 20)
    assert disk.still_hangs
    assert not recordings(tmp_path)
    disk.go_on()
