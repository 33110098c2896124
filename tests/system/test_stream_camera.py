"""Network cameras: an RTSP server in its own process, and JPEG over HTTP, both on loopback."""

import contextlib
import gc
import os
import threading
import time
import tracemalloc

import pytest
from clock_picture import WHOLE_BLOCK, damage, shown_ms
from network_cameras import http_camera, line_to, rtsp_camera, silent_camera
from stream_gauge import status

from appliance.cameras.source import CameraError
from appliance.cameras.stream import reader
from appliance.cameras.stream.reader import OPEN_TIME_S, READ_TIME_S, StreamPlace
from appliance.cameras.stream.settings import StreamCamera, StreamPictures
from appliance.cameras.stream.source import StreamPictureSource, StreamSource

pytestmark = pytest.mark.waiting

PERIOD_S = 0.04
SLACK_MS = 150  # of the server's own drawing and coding on a busy computer
STALL_S = 2.0
AT_ONCE, ROUNDS = 20, 30


def source_of(address, **settings):
    given = {"delay_ms": 0.0} | settings
    return StreamSource(StreamCamera(kind="stream", left=address, right=address, **given), 20_000)


def pairs_of(source, number):
    return [pair for _ in range(number) if (pair := source.next(2.0))]


def luma(pair):
    return pair.sent[0].measured[:, :, 0]


def later_than_exposed_ms(pair):
    """How much younger a pair is said to be than its picture shows."""
    return 1000 * pair.exposed_monotonic_s - shown_ms(luma(pair))


@contextlib.contextmanager
def tracing():
    tracemalloc.start()
    try:
        yield
    finally:
        tracemalloc.stop()


def play(source, seconds):
    until_s = time.monotonic() + seconds
    while time.monotonic() < until_s:
        source.next(1.0)


@contextlib.contextmanager
def camera_of(kind):
    if kind == "http":
        with http_camera() as port:
            yield f"http://127.0.0.1:{port}/left", port
    else:
        with rtsp_camera(codec=kind) as camera:
            yield camera.address, camera.port


@pytest.mark.parametrize(
    ("kind", "transport", "samples"),
    [("h264", "tcp", "luma"), ("h264", "udp", "luma"), ("mjpeg", "tcp", "luma"), ("http", "tcp", "grey")],
)
def test_pairs_are_in_order_whole_and_as_old_as_they_show(kind, transport, samples):
    with camera_of(kind) as (address, _), source_of(address, transport=transport) as source:
        pairs = pairs_of(source, 40)
    assert len(pairs) == 40
    assert {pair.sent[0].coding.samples for pair in pairs} == {samples}
    assert max(damage(luma(pair)) for pair in pairs) < WHOLE_BLOCK
    assert max(later_than_exposed_ms(pair) for pair in pairs) < SLACK_MS
    numbers = [pair.sequence for pair in pairs]
    assert numbers == sorted(set(numbers))


def test_the_cameras_own_clock_tells_when_a_picture_was_exposed():
    with rtsp_camera() as camera, source_of(camera.address, clock="camera", delay_ms=2000.0) as source:
        pairs = pairs_of(source, 40)
    apart_ms = sorted(later_than_exposed_ms(pair) for pair in pairs)
    assert abs(apart_ms[len(apart_ms) // 2]) < PERIOD_S * 1000


@pytest.mark.parametrize("kind", ["h264", "mjpeg", "http"])
def test_a_stall_makes_pictures_older_and_nothing_fresh(kind):
    with (
        camera_of(kind) as (address, port),
        line_to(port) as line,
        source_of(address.replace(str(port), str(line.port))) as source,
    ):
        pairs = pairs_of(source, 25)
        stall = threading.Thread(target=line.stall, args=(STALL_S,))
        stall.start()
        stalled_s = time.monotonic()
        pairs += pairs_of(source, 75)
        stall.join()
    assert max(later_than_exposed_ms(pair) for pair in pairs) < SLACK_MS
    assert pairs[-1].exposed_monotonic_s > stalled_s + STALL_S  # and it goes on afterwards


@pytest.mark.parametrize("transport", ["tcp", "udp"])
def test_no_damaged_picture_is_let_through_when_packets_are_lost(transport):
    with rtsp_camera() as camera, source_of(camera.address, transport=transport) as source:
        camera.tell("lose 0.005")
        pairs = pairs_of(source, 250)
        assert pairs[-1].dropped > 10  # there was something to let through
    assert [pair.sequence for pair in pairs if damage(luma(pair)) > WHOLE_BLOCK] == []


def test_a_size_that_changes_is_a_fault_and_is_not_scaled():
    with rtsp_camera() as camera, source_of(camera.address) as source:
        before = source.next(2.0)
        camera.tell("size 320x240")
        with pytest.raises(CameraError, match=r"pictures were 640 x 480 .*, and are 320 x 240") as raised:
            play(source, 10)
    assert before.left.shape[:2] == (480, 640)
    assert raised.value.fault == "picture_size_changed"


def test_a_stream_that_falls_silent_is_lost():
    with rtsp_camera() as camera, source_of(camera.address) as source:
        camera.tell("stand")
        started_s = time.monotonic()
        with pytest.raises(CameraError, match=r"no picture for 3 s"):
            play(source, 10)
    assert time.monotonic() - started_s < READ_TIME_S + 6


def test_a_camera_that_accepts_and_stays_silent_ends_in_time_and_leaves_no_thread():
    with silent_camera() as port:
        threads = threading.active_count()
        for scheme in ("rtsp", "http"):
            started_s = time.monotonic()
            with pytest.raises(CameraError, match="cannot be opened"), source_of(f"{scheme}://127.0.0.1:{port}/live"):
                pass
            assert time.monotonic() - started_s < 2 * OPEN_TIME_S
        assert threading.active_count() == threads


def traced_bytes():
    """Bytes of Python's objects, without those of the coverage measurement, which keeps something of each thread."""
    snapshot = tracemalloc.take_snapshot().filter_traces([tracemalloc.Filter(False, "*/coverage/*")])
    return sum(trace.size for trace in snapshot.traces)


def test_a_camera_that_stays_silent_costs_no_memory_however_often_it_is_opened(monkeypatch):
    monkeypatch.setattr(reader, "OPEN_TIME_S", 0.05)
    news = threading.Condition()
    with silent_camera() as port:
        place = StreamPlace(f"rtsp://127.0.0.1:{port}/live", None, "tcp", camera_clock=False, delay_s=0.0)

        def open_all(rounds):
            for _ in range(rounds):
                streams = [reader.StreamReader(place, news) for _ in range(AT_ONCE)]
                for stream in streams:
                    with pytest.raises(CameraError):
                        stream.wait_for_first()
                    stream.wait_for_end()
            gc.collect()

        def grown_bytes(held):
            open_all(10)
            before = held()
            open_all(ROUNDS)
            return held() - before

        # of the process, where an open stream that FFmpeg keeps costs tens of kB
        assert grown_bytes(lambda: 1024 * status(os.getpid())[1]) < 4096 * ROUNDS * AT_ONCE
        with tracing():  # Python's own objects, to the byte
            assert grown_bytes(traced_bytes) < 150 * ROUNDS * AT_ONCE


@pytest.mark.parametrize("address", ["rtsp://127.0.0.1:9/live", "http://127.0.0.1:9/live", "/dev/video77"])
def test_a_camera_that_is_not_there_is_one_sentence(address):
    with pytest.raises(CameraError, match=rf"{address}: cannot be opened \(.*\); check address, camera and network"):
        source_of(address).__enter__()


def credentials(tmp_path, text, mode=0o600):
    path = tmp_path / "camera"
    path.write_text(text)
    path.chmod(mode)
    return path


def test_user_and_password_of_any_letters_open_the_stream(tmp_path):
    path = credentials(tmp_path, "mill@hall\np#a@ss/w:ö?\n")
    with rtsp_camera(credentials=path) as camera, source_of(camera.address, credentials=path) as source:
        assert source.next(2.0) is not None


def test_a_wrong_password_is_told_without_it(tmp_path):
    path = credentials(tmp_path, "mill\nnot-the-secret\n")
    (tmp_path / "true").write_text("mill\nother\n")
    with rtsp_camera(credentials=tmp_path / "true") as camera, pytest.raises(CameraError) as raised:
        source_of(camera.address, credentials=path).__enter__()
    assert "401 Unauthorized" in str(raised.value)
    assert "not-the-secret" not in str(raised.value)


def test_credentials_of_the_service_go_first(tmp_path, monkeypatch):
    monkeypatch.setenv("CREDENTIALS_DIRECTORY", str(tmp_path))
    path = credentials(tmp_path, "mill\nsecret\n", 0o400)
    elsewhere = tmp_path / "elsewhere" / "camera"
    with rtsp_camera(credentials=path) as camera, source_of(camera.address, credentials=elsewhere) as source:
        assert source.next(2.0) is not None


@pytest.mark.parametrize(
    ("text", "mode", "match"),
    [
        ("mill\nsecret\n", 0o644, "everybody may read it"),
        ("secret\n", 0o600, "1 lines; write the user in the first"),
        ("", 0o600, "0 lines"),
    ],
)
def test_a_file_of_credentials_that_is_no_good_is_one_sentence(tmp_path, text, mode, match):
    with pytest.raises(CameraError, match=match) as raised:
        source_of("rtsp://127.0.0.1:9/live", credentials=credentials(tmp_path, text, mode)).__enter__()
    assert "secret" not in str(raised.value)


def test_pictures_of_one_stream_are_the_newest_and_what_nobody_took_is_counted():
    with (
        http_camera() as port,
        StreamPictureSource(StreamPictures(kind="stream", address=f"http://127.0.0.1:{port}/left")) as source,
    ):
        first = source.next(1.0)
        time.sleep(10 * PERIOD_S)
        later = source.next(1.0)
    assert later.sequence >= first.sequence + 7
    assert later.dropped >= 6
