"""Confirmed ingots become references on the disk, by an operator recording by recording and by the station itself."""

import json
import threading

import cv2
import numpy as np
import pytest
from ingot_recording import BOTTOM, EMPTY, write_recording

from appliance.ingot.learned_references import current_number, forget_confirmed, history, read_confirmed, use
from appliance.ingot.learning import Learning
from appliance.ingot.settings import IngotSettings
from appliance.ingot.station import run
from appliance.simulation.ingots.faces import LABELS, TYPICAL, face
from appliance.training.rendered_ends import random_camera, rendered_end
from vision.ingot.sequential_decision import IngotDecision
from vision.readings import OrientationReading

RADIUS = 32.0
SETTINGS = IngotSettings(classifier="dual")


def pictures(seed, label, count):
    """Ends of one line that fill their pictures, as a camera out of focus under another lamp shows them."""
    rng = np.random.default_rng([seed, LABELS.index(label)])
    camera = random_camera(np.random.default_rng(seed))._replace(noise_codes=1.0, blur_px=0.6)
    lamp = np.linspace(0.45, 0.8, 64)
    ends = (rendered_end(face(TYPICAL[label], rng), camera, rng) for _ in range(count + 1))
    first, *others = ends
    return first, [np.rint(cv2.GaussianBlur(end, (0, 0), 1.6) * lamp).astype(np.uint8) for end in others]


@pytest.fixture
def line(tmp_path):
    """Folder of references, and further ends of either kind."""
    ends = {}
    for label in LABELS:
        reference, ends[label] = pictures(3, label, 15)
        cv2.imwrite(str(tmp_path / f"{label}.png"), reference)
    return tmp_path, ends


def confirm(folder, label, ends):
    """What `orient --learn LABEL` does with a recording of some ingots."""
    learning = Learning(folder, SETTINGS, label)
    for number, end in enumerate(ends, 1):
        seen = OrientationReading(present=True, orientation=label, center_x=31.5, center_y=31.5, radius=RADIUS)
        decision = IngotDecision(
            ingot=number, orientation="undecided", first_frame=0, decided_frame=None, confidence=50.0, ssim_top=0.5,
            ssim_bottom=0.5,
        )  # fmt: skip
        learning.add(number, end, seen, decision)


def test_an_operator_teaches_by_recordings_that_each_show_one_kind(line):
    folder, ends = line
    for start in range(0, 15, 5):
        for label in LABELS:
            confirm(folder, label, ends[label][start : start + 5])
    number = current_number(folder)
    assert number > 0
    told = json.loads((folder / "learned" / f"{number:06d}" / "learned.json").read_text(encoding="utf-8"))
    assert (told["confirmed_by"], told["before"]) == ("operator", number - 1)
    assert [len(kept) for kept in read_confirmed(folder)] == [12, 12]


def test_after_a_way_back_nothing_is_learned_again_from_what_was_confirmed_before(line):
    folder, ends = line
    for label in LABELS * 2:
        confirm(folder, label, ends[label][:12])
    kept = history(folder)
    use(folder, 0)
    forget_confirmed(folder)
    confirm(folder, "top", ends["top"][12:15])
    assert (current_number(folder), history(folder)) == (0, kept)


class Heard:
    """The supervisor's end of a link; closes the station after some messages."""

    dropped = 0

    def __init__(self, closed, messages):
        self._closed, self._messages, self.heard = closed, messages, []

    def send(self, message):
        self.heard.append(message)
        if len(self.heard) >= self._messages:
            self._closed.set()


@pytest.fixture
def station(recordings, tmp_path):
    """Runs the station on a bottom that passes, and returns what it said."""
    for name in ("top.png", "bottom.png", "roi.json"):
        (tmp_path / name).write_bytes((recordings / "ingot_line" / name).read_bytes())
    recording = write_recording(tmp_path / "line", recordings / "ingot_line", EMPTY, BOTTOM)

    def run_station(*, learn):
        camera = {"kind": "recording", "path": recording, "rate_hz": 0}
        settings = IngotSettings.model_validate({"camera": camera, "references": tmp_path, "learn": learn})
        closed = threading.Event()
        link = Heard(closed, len(list(recording.iterdir())) - 8)
        run(settings, link, closed)
        return link.heard

    return run_station


@pytest.mark.parametrize("learn", [True, False])
def test_the_station_confirms_ends_where_its_setting_says_so(station, tmp_path, learn):
    station(learn=learn)
    assert [len(ends) for ends in read_confirmed(tmp_path)] == ([0, 1] if learn else [0, 0])


def test_damaged_confirmed_ends_cost_what_could_be_learned_and_not_the_readings(station, tmp_path):
    damaged = tmp_path / "learned" / "confirmed.npz"
    damaged.parent.mkdir()
    damaged.write_bytes(b"PK no archive")
    said = station(learn=True)
    assert any(message.kind == "ingot" and message.reading.orientation == "bottom" for message in said)
    assert damaged.read_bytes() == b"PK no archive"
