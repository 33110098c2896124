"""Network cameras, played by a server of this test that sends JPEG pictures as a camera does."""

import contextlib
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import cv2
import numpy as np
import pytest

from appliance.cameras.source import CameraError
from appliance.cameras.stream.settings import StreamCamera, StreamPictures
from appliance.cameras.stream.source import READ_TIME_S, StreamPictureSource, StreamSource

PERIOD_S = 0.04
SHAPE = (48, 64)


class Cameras:
    """What the cameras behind the server do: how many pictures, how late, silent from when on."""

    def __init__(self):
        self.start_s = None
        self.frames = {"left": 10_000, "right": 10_000}
        self.late_s = {"left": 0.0, "right": 0.0}
        self.silent_from = {"left": 10_000, "right": 10_000}
        self.over = threading.Event()


@contextlib.contextmanager
def serving(cameras):
    class Handler(BaseHTTPRequestHandler):
        def log_message(self, *_):
            pass

        def do_GET(self):
            side = self.path.strip("/")
            if side not in cameras.frames:
                self.send_error(404)
                return
            self.send_response(200)
            self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=picture")
            self.end_headers()
            cameras.start_s = cameras.start_s or time.monotonic() + 0.3
            with contextlib.suppress(OSError):
                for number in range(cameras.frames[side]):
                    due = cameras.start_s + number * PERIOD_S + cameras.late_s[side]
                    if due < time.monotonic() - 2 * PERIOD_S:
                        continue
                    if number >= cameras.silent_from[side]:
                        cameras.over.wait()
                    if cameras.over.wait(max(0.0, due - time.monotonic())):
                        return
                    self.send_picture(number)

        def send_picture(self, number):
            jpeg = cv2.imencode(".jpg", np.full((*SHAPE, 3), number % 250, np.uint8))[1].tobytes()
            head = f"--picture\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
            self.wfile.write(head.encode() + jpeg + b"\r\n")

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        cameras.over.set()
        server.shutdown()
        server.server_close()


def streams(base, **settings):
    camera = StreamCamera(kind="stream", left=f"{base}/left", right=f"{base}/right", **settings)
    return StreamSource(camera, 10_000)


def play(source):
    while True:
        source.next(1.0)


def test_pairs_of_two_streams_are_in_order_and_of_one_moment():
    with serving(Cameras()) as base, streams(base, delay_ms=50.0) as source:
        pairs = [source.next(2.0) for _ in range(20)]
    assert None not in pairs
    assert all(pair.left.shape == (*SHAPE, 3) for pair in pairs)
    assert all(abs(int(pair.left[0, 0, 0]) - int(pair.right[0, 0, 0])) <= 3 for pair in pairs)
    numbers = [pair.sequence for pair in pairs]
    assert numbers == sorted(set(numbers))
    assert all(0.05 <= time.monotonic() - pair.exposed_monotonic_s < 60 for pair in pairs)


def test_streams_that_are_out_of_step_say_how_far():
    cameras = Cameras()
    cameras.late_s["right"] = PERIOD_S / 2
    with serving(cameras) as base, streams(base) as source:
        pairs = [pair for _ in range(20) if (pair := source.next(1.0))]
    apart_us = sorted(abs(pair.left_us - pair.right_us) for pair in pairs)
    assert apart_us[len(pairs) // 2] == pytest.approx(1e6 * PERIOD_S / 2, rel=0.3)


@pytest.mark.parametrize(("what", "match"), [("frames", "ended"), ("silent_from", "no picture for|ended")])
def test_a_stream_that_ends_or_falls_silent_is_lost(what, match):
    cameras = Cameras()
    getattr(cameras, what)["right"] = 40
    with serving(cameras) as base, streams(base) as source:
        started = time.monotonic()
        with pytest.raises(CameraError, match=match):
            play(source)
    assert time.monotonic() - started < 40 * PERIOD_S + READ_TIME_S + 10


def test_an_address_without_a_camera_is_one_sentence():
    with serving(Cameras()) as base:
        source = StreamSource(StreamCamera(kind="stream", left=f"{base}/left", right=f"{base}/nobody"), 10_000)
        with pytest.raises(CameraError, match=r"nobody: cannot be opened; check address, camera and network"), source:
            pass


def test_a_device_that_is_not_there_is_one_sentence():
    source = StreamPictureSource(StreamPictures(kind="stream", address="/dev/video77"))
    with pytest.raises(CameraError, match="/dev/video77: cannot be opened"), source:
        pass


def test_pictures_of_one_stream_are_the_newest_and_what_nobody_took_is_counted():
    with (
        serving(Cameras()) as base,
        StreamPictureSource(StreamPictures(kind="stream", address=f"{base}/left")) as source,
    ):
        first = source.next(1.0)
        time.sleep(10 * PERIOD_S)
        later = source.next(1.0)
    assert later.sequence >= first.sequence + 8
    assert later.dropped >= 7
