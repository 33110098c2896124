"""Cameras on loopback for tests: an RTSP server in its own process, JPEG over HTTP, a line that stalls."""

import contextlib
import math
import socket
import subprocess
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import cv2
from clock_picture import clock_picture, now_ms


class RtspCamera:
    """GStreamer's RTSP server, played by `rtsp_camera.py`; see its lines."""

    def __init__(self, process):
        self._process = process
        self.port = int(process.stdout.readline())
        self.address = f"rtsp://127.0.0.1:{self.port}/stream"

    def tell(self, line):
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()


@contextlib.contextmanager
def rtsp_camera(**options):
    given = [f"--{name}={value}" for name, value in options.items() if name != "show"]
    given += ["--show", *map(str, options["show"])] if "show" in options else []
    script = Path(__file__).parent / "rtsp_camera.py"
    with subprocess.Popen(
        [sys.executable, str(script), *given], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            yield RtspCamera(process)
        finally:
            process.kill()


class Line:
    """A connection between receiver and camera; while `stalled`, what the camera sends waits in it."""

    def __init__(self, port):
        self._port = port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self.flows = threading.Event()
        self.flows.set()
        self._over = False
        threading.Thread(target=self._accept, daemon=True).start()

    def stall(self, seconds):
        self.flows.clear()
        time.sleep(seconds)
        self.flows.set()

    def close(self):
        self._over = True
        self._listener.close()

    def _accept(self):
        with contextlib.suppress(OSError):
            while not self._over:
                near, _ = self._listener.accept()
                far = socket.create_connection(("127.0.0.1", self._port))
                threading.Thread(target=self._carry, args=(near, far, False), daemon=True).start()
                threading.Thread(target=self._carry, args=(far, near, True), daemon=True).start()

    def _carry(self, source, target, stalls):
        with contextlib.suppress(OSError), source, target:
            while data := source.recv(65536):
                if stalls:
                    self.flows.wait()
                target.sendall(data)


@contextlib.contextmanager
def line_to(port):
    line = Line(port)
    try:
        yield line
    finally:
        line.close()


@contextlib.contextmanager
def silent_camera(port=0):
    """Port that accepts connections and never answers; older ones than the newest hundred are closed."""
    with socket.create_server(("127.0.0.1", port)) as listener:
        held = []

        def accept():
            with contextlib.suppress(OSError):
                while True:
                    held.append(listener.accept()[0])
                    if len(held) > 100:
                        held.pop(0).close()

        threading.Thread(target=accept, daemon=True).start()
        yield listener.getsockname()[1]


@contextlib.contextmanager
def http_camera(columns=640, rows=480, picture=None, rate=25):
    """Port of a server that sends JPEG pictures in rhythm to everybody who asks: clock pictures, or by their moment."""
    picture = picture or (lambda moment_ms: clock_picture(moment_ms, columns, rows))

    class Handler(BaseHTTPRequestHandler):
        def log_message(self, *_):
            pass

        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=picture")
            self.end_headers()
            with contextlib.suppress(OSError):
                while True:
                    now_s = time.monotonic()
                    time.sleep((math.floor(now_s * rate) + 1) / rate - now_s)
                    jpeg = cv2.imencode(".jpg", picture(now_ms()))[1].tobytes()
                    head = f"--picture\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
                    self.wfile.write(head.encode() + jpeg + b"\r\n")

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield server.server_port
    finally:
        server.shutdown()
        server.server_close()
