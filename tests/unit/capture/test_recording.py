"""`hotgauge capture recording`, `background` and `references`: what was sent is what a reader gets back."""

import csv
import itertools
import json
import time
from dataclasses import replace

import cv2
import numpy as np
import pytest

from appliance.cameras.pacing import Pacer, utc_ms
from appliance.cameras.recording.pairs import Recording, RecordingSource
from appliance.cameras.recording.picture_file import read_picture, read_told_coding
from appliance.cameras.recording.pictures import PictureRecording
from appliance.cameras.settings import LivenessSettings
from appliance.cameras.simulated.thermal import ThermalMillSource
from appliance.cameras.source import Frame, FramePair
from appliance.capture.console import Console
from appliance.capture.error import CaptureError
from appliance.capture.picture_writer import keep_coding, write_picture
from appliance.capture.recording import record
from appliance.cli.main import main
from appliance.ingot.reader_setup import load_view
from vision.ingot.classifiers.similarity import as_reference, similarity
from vision.sent_picture import LUMA_709, Coding, sent_picture

SIZE = (48, 64)
QUIET = LivenessSettings()


class Camera:
    """Two cameras or one that send pictures of a coding, each of its own noise."""

    simulated = True

    def __init__(self, coding, cameras=2, rate_hz=50.0, skip=0):
        self._coding = coding
        self._cameras = cameras
        self._rate_hz = rate_hz
        self._skip = skip
        self.sent = []

    def __enter__(self):
        self._pacer = Pacer(self._rate_hz)
        return self

    def __exit__(self, *_):
        pass

    def next(self, timeout_s):
        number, moment_s = self._pacer.next_due(timeout_s)
        pictures = tuple(self._picture(2 * number + camera) for camera in range(self._cameras))
        self.sent.append(pictures)
        moments = {"exposed_monotonic_s": moment_s, "exposed_utc_ms": utc_ms(moment_s), "dropped": number * self._skip}
        if self._cameras == 1:
            return Frame(pictures[0].shown, number, sent=pictures[0], **moments)
        stamps = {"left_us": 20_000 * number, "right_us": 20_000 * number + 7}
        return FramePair(pictures[0].shown, pictures[1].shown, number, sent=pictures, **stamps, **moments)

    def _picture(self, seed):
        rng = np.random.default_rng(seed)
        coding = self._coding
        kind = np.uint8 if coding.bits == 8 else np.uint16
        shape = (*SIZE, 3) if coding.samples == "colour" else SIZE
        codes = rng.integers(coding.black, coding.white + 1, shape).astype(kind)
        shown = rng.integers(0, 256, (*SIZE, 3), dtype=np.uint8) if coding.samples == "luma" else None
        return sent_picture(codes, coding, shown)


RNG = np.random.default_rng(5)
CODINGS = [
    Coding("grey"),
    Coding("colour"),
    Coding("grey", bits=12),
    Coding("mosaic", bits=10, mosaic="GBRG"),
    Coding("luma", full_range=False, compression="video"),
    Coding("luma", full_range=True, luma_weights=LUMA_709, compression="video"),
    Coding("luma", bits=10, full_range=False, luma_weights=LUMA_709, compression="video"),
    Coding("luma", full_range=False),
    Coding("luma", full_range=False, compression="video", quantiser=35.0),
    Coding("colour", compression="jpeg", quality=90),
]


@pytest.fixture
def console():
    with open("/dev/null", "r+", encoding="utf-8") as nowhere:  # noqa: PTH123
        yield Console(nowhere, nowhere)


@pytest.mark.parametrize("coding", CODINGS, ids=lambda coding: f"{coding.samples}-{coding.bits}-{coding.full_range}")
def test_a_recorded_pair_has_the_code_values_and_the_coding_that_were_sent(coding, tmp_path, console):
    camera = Camera(coding)
    done = record(camera, QUIET, tmp_path / "recording", 0.25, console)
    recording = Recording(tmp_path / "recording")
    frames = list(recording)
    assert len(frames) == done.frames >= 2
    assert done.size == SIZE[::-1]
    for (number, *pictures), sent in zip(frames, camera.sent, strict=False):
        for picture, original in zip(pictures, sent, strict=True):
            assert picture.coding == coding, number
            assert np.array_equal(picture.measured, original.measured), number


def test_colours_beside_luma_come_back_to_a_few_levels(tmp_path, console):
    class Smooth(Camera):
        def _picture(self, seed):
            slope = np.linspace(20 + seed % 50, 200, SIZE[1])[None, :, None] * np.array([0.3, 0.6, 1.0])
            shown = np.broadcast_to(slope, (*SIZE, 3)).astype(np.uint8).copy()
            luma = cv2.cvtColor(shown, cv2.COLOR_BGR2YUV)[:, :, 0].astype(float)
            codes = np.round(16 + luma * 219 / 255).astype(np.uint8)
            return sent_picture(codes, Coding("luma", full_range=False, compression="video"), shown)

    camera = Smooth(None)
    record(camera, QUIET, tmp_path / "recording", 0.1, console)
    _, left, _ = next(iter(Recording(tmp_path / "recording")))
    apart = np.abs(left.shown[2:].astype(int) - camera.sent[0][0].shown[2:].astype(int))
    assert np.percentile(apart, 99) <= 6


def test_stamps_stand_beside_a_recording_of_pairs_and_what_was_lost_is_counted(tmp_path, console):
    done = record(Camera(Coding("grey"), skip=2), QUIET, tmp_path / "recording", 0.2, console)
    rows = list(csv.DictReader((tmp_path / "recording" / "timestamps.csv").read_text().splitlines()))
    assert [int(row["right_us"]) - int(row["left_us"]) for row in rows] == [7] * done.frames
    assert {row["stamped"] for row in rows} == {"0"}
    steps = [int(b["left_us"]) - int(a["left_us"]) for a, b in itertools.pairwise(rows)]
    assert min(steps) >= 20_000
    assert done.lost >= 2 * (done.frames - 1)


@pytest.mark.parametrize("stamped", [False, True])
def test_a_recording_proves_no_more_of_its_pairs_than_the_cameras_did(tmp_path, console, stamped):
    class Pairs(Camera):
        def next(self, timeout_s):
            return replace(super().next(timeout_s), stamped=stamped)

    record(Pairs(Coding("grey")), QUIET, tmp_path / "recording", 0.1, console)
    with RecordingSource(tmp_path / "recording", 0, loop=False) as source:
        assert source.next(1.0).synchronous is stamped


@pytest.mark.parametrize("coding", [Coding("grey"), Coding("luma", full_range=False, compression="video")])
def test_one_camera_is_recorded_as_one(coding, tmp_path, console):
    camera = Camera(coding, cameras=1)
    done = record(camera, QUIET, tmp_path / "recording", 0.2, console)
    recording = PictureRecording(tmp_path / "recording")
    assert len(recording) == done.frames
    for position, (sent,) in enumerate(camera.sent[: done.frames]):
        assert np.array_equal(recording.read(position)[1].measured, sent.measured)


def test_a_folder_with_something_in_it_is_not_recorded_over(tmp_path, console):
    (tmp_path / "left").mkdir()
    with pytest.raises(CaptureError, match="is not empty; give a new or empty folder"):
        record(Camera(Coding("grey")), QUIET, tmp_path, 0.1, console)


def test_pictures_that_never_change_are_not_recorded_but_told(tmp_path, console, monkeypatch):
    class Frozen(Camera):
        def _picture(self, _seed):
            return super()._picture(1)

    started_s = time.monotonic()
    hasty = LivenessSettings(lost_after_ms=100)
    monkeypatch.setattr("appliance.capture.recording.FIRST_WITHIN_S", 1.0)
    frozen = Frozen(Coding("grey"))
    frozen.simulated = False  # of a recording the first picture counts
    with pytest.raises(CaptureError, match="picture does not change"):
        record(frozen, hasty, tmp_path / "recording", 0.5, console)
    assert time.monotonic() - started_s < 5


def test_a_board_picture_of_limited_luma_reads_as_the_same_light(tmp_path):
    coding = Coding("luma", full_range=False, compression="video")
    codes = np.arange(16, 236, dtype=np.uint8).reshape(10, 22)
    picture = sent_picture(codes, coding, np.zeros((10, 22, 3), np.uint8))
    write_picture(tmp_path / "left_00.png", picture)
    keep_coding(tmp_path, coding)
    back = read_picture(tmp_path / "left_00.png", read_told_coding(tmp_path))
    light = (back.measured.astype(float) - back.coding.black) / (back.coding.white - back.coding.black)
    assert light[:, :, 0] == pytest.approx((codes - 16.0) / 219, abs=1e-5)


def test_pictures_of_another_coding_do_not_join_a_folder(tmp_path):
    keep_coding(tmp_path, Coding("grey", bits=12))
    keep_coding(tmp_path, Coding("grey", bits=12))
    with pytest.raises(CaptureError, match="coded otherwise than this camera's; give a new folder"):
        keep_coding(tmp_path, Coding("grey", bits=10))


def test_the_mill_is_recorded_through_the_command(tmp_path, capsys):
    config = tmp_path / "ingots.toml"
    config.write_text('[ingot.camera]\nkind = "mill"\nrate_hz = 20.0\n')
    words = ["capture", "recording", "--output", str(tmp_path / "line"), "--seconds", "0.5", "--station", "ingot"]
    assert main([*words, "--config", str(config)]) == 0
    said = capsys.readouterr().out
    frames = len(list((tmp_path / "line").glob("*.png")))
    assert f"{tmp_path / 'line'}: {frames} frames of " in said
    assert frames >= 2


def write_line(folder, pictures):
    """A recording of the simulated thermal line, and settings that play it."""
    folder.mkdir()
    for number, picture in enumerate(pictures):
        cv2.imwrite(str(folder / f"{number:06}.png"), picture)
    config = folder.with_suffix(".toml")
    config.write_text(
        '[sizing]\nmethod = "conveyor"\n[sizing.conveyor]\nbarrier_mm = 600\nbarrier_height_mm = 100\n'
        f'[sizing.camera]\nkind = "recording"\npath = "{folder}"\nrate_hz = 50.0\n'
    )
    return config


def test_the_empty_line_is_taken_and_checked_by_the_gauge(tmp_path, capsys):
    empty = [picture.shown for picture in ThermalMillSource(1, 10.0).empty()]
    noise = np.random.default_rng(1)
    noisy = [np.clip(empty[0] + noise.normal(0, 2, empty[0].shape), 0, 255).astype(np.uint8) for _ in range(24)]
    output = tmp_path / "empty.png"
    words = ["capture", "background", "--output", str(output)]
    assert main([*words, "--config", str(write_line(tmp_path / "line", noisy))]) == 0
    assert "the line without a bar; barriers: two straight ones in" in capsys.readouterr().out
    kept = read_picture(output).shown.astype(float)
    assert (kept - empty[0]).std() < 0.6 * 2  # the median of 20 forgets most of the noise


def test_a_line_on_which_a_bar_passes_is_not_kept(tmp_path, capsys):
    with ThermalMillSource(1, 0.0) as source:
        passing = [source.next(1.0).picture for _ in range(60)]
    words = ["capture", "background", "--output", str(tmp_path / "empty.png")]
    assert main([*words, "--config", str(write_line(tmp_path / "line", passing[::2]))]) == 2
    assert "of the picture changes within" in capsys.readouterr().err
    assert not (tmp_path / "empty.png").exists()


def test_the_empty_line_of_two_cameras_is_not_needed(tmp_path, capsys):
    assert main(["capture", "background", "--output", str(tmp_path / "empty.png")]) == 2
    assert "only the conveyor method needs the empty line" in capsys.readouterr().err


def test_references_are_taken_where_the_reader_finds_ends(tmp_path, capsys, recordings):
    """The camera plays pictures of one ingot that lies: its end becomes the reference, and its regions go along."""
    line = recordings / "ingot_line"
    regions = json.loads((line / "roi.json").read_text())
    for end, sequence in (("top", "seq02"), ("bottom", "seq01")):
        table = csv.DictReader((line / sequence / "truth.csv").read_text().splitlines())
        lies = [row["frame"] for row in table if row["label"] == end and row["touch"] == row["over"] == "0"]
        folder = tmp_path / end
        folder.mkdir()
        picture = cv2.imread(str(line / sequence / f"{int(lies[len(lies) // 2]):06}.jpg")).astype(np.int16)
        for number in range(3):  # an end that lies still; only the noise is new
            noisy = np.clip(picture + RNG.integers(-1, 2, picture.shape), 0, 255).astype(np.uint8)
            cv2.imwrite(str(folder / f"{number:06}.png"), noisy)
        config = tmp_path / f"{end}.toml"
        config.write_text(
            f"[ingot]\ncrop = {regions['roi_crop']}\ncentroid = {regions['roi_centroid']}\n"
            f'[ingot.camera]\nkind = "recording"\npath = "{folder}"\nrate_hz = 20.0\n'
        )
        words = ["capture", "references", "--output", str(tmp_path / "references"), "--end", end]
        assert main([*words, "--config", str(config)]) == 0, capsys.readouterr().err
        assert read_picture(tmp_path / "references" / f"{end}.png").size == (64, 64)
    taken = load_view(tmp_path / "references")
    assert [list(taken.crop), list(taken.centroid)] == [regions["roi_crop"], regions["roi_centroid"]]
    own = load_view(line).references
    top, bottom = as_reference(own.top), as_reference(own.bottom)
    assert similarity(taken.references.top, top) > similarity(taken.references.top, bottom)
    assert similarity(taken.references.bottom, bottom) > similarity(taken.references.bottom, top)
