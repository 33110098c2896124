"""The real program with network cameras: it ends cleanly, says little, and never a password."""

import contextlib
import socket
import subprocess
import time
from functools import partial

import pytest
import stream_gauge
from network_cameras import rtsp_camera, silent_camera
from running import HOTGAUGE, free_port
from said import Running, said_by
from stream_gauge import SIZE, managed, measures, reload_changed, status

LETTERS = "p#a@ss/w:word"
settings = partial(stream_gauge.settings, credentials="camera")  # a file beside the settings
ROUNDS, RELOADS = 5, 3  # fifty of each: tests/studies/stream_stops.py
GROWN_MAX_KB = 4096


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("network")
    (folder / "camera").write_text(f"mill\n{LETTERS}\n")
    (folder / "camera").chmod(0o600)
    return folder


@pytest.mark.waiting
def test_doctor_ends_cleanly_and_finds_the_pair(folder):
    with rtsp_camera(size=SIZE, credentials=folder / "camera") as camera:
        config = settings(folder, camera.address, free_port())
        for _ in range(ROUNDS):
            code, said = said_by("doctor", "--config", config)
            assert code in {0, 1}, said
            assert "a pair of 800 x 600 pixels" in said
            assert "Fatal" not in said
            assert LETTERS not in said


@pytest.mark.waiting
def test_doctor_ends_cleanly_with_a_camera_that_is_silent(folder):
    with silent_camera() as port:
        code, said = said_by("doctor", "--config", settings(folder, f"rtsp://127.0.0.1:{port}/live", free_port()))
    assert code == 1
    assert "cannot be opened" in said
    assert "Fatal" not in said


def test_a_camera_that_dies_and_comes_back_is_a_few_lines_and_the_stop_is_clean(folder):
    rtsp_port, port = free_port(), free_port()
    config = settings(folder, f"rtsp://127.0.0.1:{rtsp_port}/stream", port)
    with contextlib.ExitStack() as stack:
        with rtsp_camera(size=SIZE, credentials=folder / "camera", port=rtsp_port):
            gauge = stack.enter_context(Running(config, port))
            assert gauge.said_within("Hotgauge measures", 60), gauge.lines
            time.sleep(8)
            gauge.take_lines()
        assert gauge.said_within("camera_lost", 15), gauge.lines
        time.sleep(20)
        gone = gauge.take_lines()
        with rtsp_camera(size=SIZE, credentials=folder / "camera", port=rtsp_port):
            assert gauge.said_within("camera_lost is over", 40), gauge.lines
            time.sleep(5)
            back = gauge.take_lines()
            assert gauge.stop() == 0
    assert len(gone) <= 3, gone
    assert len(back) <= 2, back
    assert not any(LETTERS in line or "Fatal" in line for line in gone + back + gauge.lines)


@pytest.mark.waiting
def test_a_camera_that_accepts_and_stays_silent_costs_no_thread_and_no_memory(folder):
    rtsp_port, port = free_port(), free_port()
    config = settings(folder, f"rtsp://127.0.0.1:{rtsp_port}/stream", port)
    with contextlib.ExitStack() as stack:
        with rtsp_camera(size=SIZE, credentials=folder / "camera", port=rtsp_port):
            gauge = stack.enter_context(Running(config, port))
            assert gauge.said_within("Hotgauge measures", 60), gauge.lines
            measures(gauge)
        stack.enter_context(silent_camera(rtsp_port))
        assert gauge.said_within("camera_lost", 20), gauge.lines
        counts = []
        for _ in range(4):
            time.sleep(9)
            counts.append(status(gauge.appliance.station()))
        assert gauge.stop() == 0
    threads, memory_kb = zip(*counts, strict=True)
    assert min(threads[2:]) <= max(threads[:2]) + 2, counts  # those that open a stream again come and go
    assert max(memory_kb) - min(memory_kb) < GROWN_MAX_KB, counts


@pytest.mark.waiting
def test_reloads_and_the_stop_with_streams_open_are_clean(folder):
    port = free_port()
    with rtsp_camera(size=SIZE, credentials=folder / "camera") as camera:
        config = settings(folder, camera.address, port)
        with managed(config, port) as gauge:
            measures(gauge)
            for number in range(RELOADS):
                reload_changed(gauge, config, delay_ms=200 + number)
            assert gauge.stop() == 0
            gauge.listener.join(5)
    assert not any("Fatal" in line for line in gauge.lines), gauge.lines


@pytest.mark.waiting
@pytest.mark.parametrize("command", ["check-config", "doctor", "run", "orient", "measure", "replay", "calibrate"])
def test_no_command_shows_a_password(folder, command):
    """Of an address that carries one all the same, of one with a query, and of a file of credentials."""
    with socket.create_server(("127.0.0.1", 0)) as closed:
        port = closed.getsockname()[1]
    for address in (
        f"rtsp://mill:{LETTERS}@127.0.0.1:{port}/live",
        f"http://127.0.0.1:{port}/live?password=ass/w:word",
    ):
        config = settings(folder, address, free_port())
        words = {"check-config": [config], "calibrate": [config]}.get(command, ["--config", config])
        words = [*words, folder] if command in {"orient", "measure", "replay"} else words
        process = subprocess.Popen(
            [HOTGAUGE, command, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        try:
            said, _ = process.communicate(timeout=12)
        except subprocess.TimeoutExpired:
            process.terminate()
            said, _ = process.communicate(timeout=10)
        assert said
        assert LETTERS not in said
        assert "ass/w:word" not in said


@pytest.mark.waiting
def test_an_address_with_a_password_is_refused_in_one_sentence(folder):
    code, said = said_by("check-config", settings(folder, f"rtsp://mill:{LETTERS}@10.0.0.11/live", free_port()))
    assert code == 2
    assert "sizing.camera.left: an address with user or password" in said
    assert "name a file in credentials" in said
