"""Previews: written whole, at a bounded rate, and never in the way of measuring."""

import base64
import json
import math
import threading
import time

import cv2
import numpy as np
import pytest

from appliance.files.runtime_folder import RUNTIME_VARIABLE, give_runtime_folder, preview_file, runtime_folder
from appliance.page.previews import OLD_AFTER_S, Previews
from appliance.processes import preview
from appliance.processes.preview import COLOURS, PERIOD_S, Line, PreviewWriter, sharpness, to_document


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path))
    return tmp_path


def wait_for(condition, within_s=5.0):
    until_s = time.monotonic() + within_s
    while not condition() and time.monotonic() < until_s:
        time.sleep(0.01)
    assert condition()


def test_pictures_and_figures_of_one_exposure_are_read_back(folder):
    left, right = (np.full((60, 80, 3), level, np.uint8) for level in (40, 200))
    figures = {"sequence": 7, "exposed_utc_ms": 1000, "diameter_mm": 100.5, "exposure_us": math.nan}
    PreviewWriter("sizing").offer((left, right), lambda: [[], []], figures)
    previews = Previews(folder)
    wait_for(lambda: previews.newest("sizing") is not None)
    newest = previews.newest("sizing")
    levels = [cv2.imdecode(np.frombuffer(one, np.uint8), cv2.IMREAD_COLOR).mean() for one in newest.pictures]
    assert levels == pytest.approx([40, 200], abs=1)
    assert newest.figures["diameter_mm"] == 100.5
    assert newest.figures["exposure_us"] is None
    assert previews.newest("ingot") is None


def test_an_old_preview_is_none(folder, monkeypatch):
    preview_file(folder, "sizing").write_text(json.dumps({"pictures": [], "figures": {}}))
    assert Previews(folder).newest("sizing") is not None
    later_s = time.time() + OLD_AFTER_S + 1
    monkeypatch.setattr("appliance.page.previews.time.time", lambda: later_s)
    assert Previews(folder).newest("sizing") is None


@pytest.mark.parametrize("text", ["", "{", "{}", '{"pictures": 3, "figures": {}}', "[]"])
def test_a_preview_that_cannot_be_read_is_none(folder, text):
    preview_file(folder, "sizing").write_text(text)
    assert Previews(folder).newest("sizing") is None


def test_offers_come_to_nothing_while_one_is_drawn_or_none_is_due_and_never_wait(folder):
    now_s, drawn, goes_on = [0.0], [], threading.Event()

    def lines():
        drawn.append(now_s[0])
        goes_on.wait(10)
        return [[]]

    writer = PreviewWriter("sizing", lambda: now_s[0])
    picture = np.zeros((600, 800), np.uint8)
    writer.offer([picture], lines, {})
    wait_for(lambda: drawn)
    for step in range(100):
        now_s[0] = step * PERIOD_S / 10
        writer.offer([picture], lines, {})
    assert len(drawn) == 1, "the first one is drawn still"
    goes_on.set()
    wait_for(lambda: len(drawn) == 2)  # the one that was drawn, and one that waited
    time.sleep(0.05)
    assert len(drawn) == 2


def test_without_a_runtime_directory_or_on_a_full_disk_nothing_happens(monkeypatch, tmp_path):
    monkeypatch.delenv(RUNTIME_VARIABLE, raising=False)
    PreviewWriter("sizing").offer([np.zeros((6, 8), np.uint8)], lambda: [[]], {})
    assert threading.active_count() < 50
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path / "gone"))
    writer = PreviewWriter("sizing")
    writer.offer([np.zeros((6, 8), np.uint8)], lambda: [[]], {})
    time.sleep(0.1)
    assert writer._thread.is_alive()


def test_a_preview_that_cannot_be_drawn_is_left_out_and_the_next_one_written(folder):
    now_s = [0.0]
    writer = PreviewWriter("sizing", lambda: now_s[0])
    picture = np.zeros((6, 8), np.uint8)
    writer.offer([picture], lambda: [[], []], {"sequence": 1})  # lines of two pictures for one
    wait_for(writer._waiting.empty)
    now_s[0] = 2 * PERIOD_S
    writer.offer([picture], lambda: [[]], {"sequence": 2})
    wait_for(lambda: Previews(folder).newest("sizing") is not None)
    assert Previews(folder).newest("sizing").figures["sequence"] == 2


def test_lines_are_drawn_where_they_are_in_a_picture_that_is_shrunk():
    picture = np.zeros((960, 2 * preview.WIDTH_PX, 3), np.uint8)
    outside = np.array([[np.nan, np.nan], [200.0, 100.0], [200.0, 900.0]])
    document = to_document([picture], [[Line("edge", outside)]], {})
    shown = cv2.imdecode(np.frombuffer(base64.b64decode(document["pictures"][0]), np.uint8), cv2.IMREAD_COLOR)
    assert shown.shape[1] == preview.WIDTH_PX
    rows, columns = np.nonzero(shown.max(axis=2) > 100)
    assert (rows.min(), rows.max()) == (pytest.approx(50, abs=2), pytest.approx(450, abs=2))
    assert columns.mean() == pytest.approx(100, abs=1)
    assert shown[250, 100].astype(float) == pytest.approx(COLOURS["edge"], abs=40)


def test_sharpness_falls_with_blur_and_does_not_depend_on_light():
    sharp = np.zeros((400, 400), np.uint8)
    sharp[:, 200:] = 200
    blurred = cv2.GaussianBlur(sharp, (0, 0), 3.0)
    assert sharpness(sharp) == pytest.approx(1.0, abs=0.01)
    assert sharpness(blurred) == pytest.approx(1 / (3 * math.sqrt(2 * math.pi)), abs=0.02)  # slope of a Gaussian edge
    assert sharpness(blurred // 2) == pytest.approx(sharpness(blurred), abs=0.02)
    assert sharpness(np.zeros((400, 400), np.uint8)) == 0


def test_a_runtime_directory_is_given_to_those_who_have_none_and_to_nobody_else(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv(RUNTIME_VARIABLE, "/run/hotgauge:/run/other")
    give_runtime_folder(5020)
    assert str(runtime_folder()) == "/run/hotgauge"
    monkeypatch.delenv(RUNTIME_VARIABLE)
    give_runtime_folder(5020)
    assert runtime_folder().parent == tmp_path
    assert runtime_folder().stat().st_mode & 0o777 == 0o700
    monkeypatch.delenv(RUNTIME_VARIABLE)
    made = next(tmp_path.glob("hotgauge-*"))
    made.rename(tmp_path / "elsewhere")
    made.symlink_to(tmp_path / "elsewhere")
    give_runtime_folder(5020)
    assert runtime_folder() is None  # a link that somebody else may have laid
