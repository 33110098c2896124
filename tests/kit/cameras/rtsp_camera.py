"""A network camera on loopback: GStreamer's RTSP server sends clock pictures, and obeys lines on its standard input.

    python rtsp_camera.py --codec h264 --size 640x480 --rate 25

Prints its port. Obeys `size 320x240`, `lose 0.02` (share of RTP packets), `stand` and `go` (pictures stop and start),
and, once it shows a folder's pictures in place of the clock (--show), `show FOLDER SECONDS`; see `shown_pictures`.
"""

import argparse
import math
import random
import sys
import threading
import time
from pathlib import Path

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstRtsp", "1.0")
gi.require_version("GstRtspServer", "1.0")

from clock_picture import clock_picture, now_ms  # noqa: E402  GObject wants its versions first
from gi.repository import GLib, Gst, GstRtsp, GstRtspServer  # noqa: E402
from shown_pictures import ShownPictures  # noqa: E402

CODECS = {
    "h264": "x264enc tune=zerolatency sliced-threads=false threads=1 "
    "speed-preset=veryfast key-int-max=25 bitrate=3000 {more} "
    "! rtph264pay config-interval=-1 name=pay0 pt=96",
    "mjpeg": "jpegenc quality=90 ! rtpjpegpay name=pay0 pt=26",
}


class Camera:
    def __init__(self, size, rate):
        self.size = size
        self.rate = rate
        self.lost_share = 0.0
        self.standing = False
        self.source = None
        self.luck = random.Random(7)
        self.shown = None

    def configure(self, _factory, media):
        self.source = media.get_element().get_child_by_name("source")
        self.set_caps()
        pay = media.get_element().get_child_by_name("pay0")
        pay.get_static_pad("src").add_probe(Gst.PadProbeType.BUFFER | Gst.PadProbeType.BUFFER_LIST, self.probe)
        threading.Thread(target=self.push, args=(self.source,), daemon=True).start()

    def set_caps(self):
        columns, rows = self.size
        caps = f"video/x-raw,format=GRAY8,width={columns},height={rows},framerate={self.rate}/1"
        self.source.set_property("caps", Gst.Caps.from_string(caps))

    def probe(self, _pad, info):
        # a list cannot be changed from here: it is lost whole, as often as its packets would be
        packets = info.get_buffer_list() if info.type & Gst.PadProbeType.BUFFER_LIST else None
        number = 1 if packets is None else packets.length()
        kept = self.luck.random() < (1 - self.lost_share) ** number
        return Gst.PadProbeReturn.OK if kept else Gst.PadProbeReturn.DROP

    def push(self, source):
        size = self.size
        while source is self.source:
            if self.standing:
                time.sleep(0.01)
                continue
            if size != self.size:
                size = self.size
                self.set_caps()
            buffer = Gst.Buffer.new_wrapped(self.picture(size).tobytes())
            if source.emit("push-buffer", buffer) != Gst.FlowReturn.OK:
                return
            self.wait_for_next()

    def wait_for_next(self):
        """Every camera of this computer exposes at the same moments, as a common trigger would have it."""
        now_s = time.monotonic()
        time.sleep((math.floor(now_s * self.rate) + 1) / self.rate - now_s)

    def picture(self, size):
        return clock_picture(now_ms(), *size) if self.shown is None else self.shown.at(now_ms())

    def obey(self, line):
        words = line.split()
        if words[0] == "show":
            self.shown.show(words[1], float(words[2]))
        elif words[0] == "size":
            self.size = tuple(map(int, words[1].split("x")))
        elif words[0] == "lose":
            self.lost_share = float(words[1])
        elif words[0] in {"stand", "go"}:
            self.standing = words[0] == "stand"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--codec", default="h264")
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--rate", type=int, default=25)
    parser.add_argument("--port", default="0")
    parser.add_argument("--credentials", type=Path, help="file with user and password, for who may look")
    parser.add_argument("--more", default="", help="properties of the encoder")
    parser.add_argument("--show", nargs=2, metavar=("FOLDER", "SECONDS"))
    parser.add_argument("--log", type=argparse.FileType("w"))
    given = parser.parse_args()
    Gst.init(None)
    camera = Camera(tuple(map(int, given.size.split("x"))), given.rate)
    if given.show:
        camera.shown = ShownPictures(given.show[0], float(given.show[1]), given.log)
    server = GstRtspServer.RTSPServer.new()
    server.set_address("127.0.0.1")
    server.set_service(given.port)
    factory = GstRtspServer.RTSPMediaFactory.new()
    source = "appsrc name=source is-live=true do-timestamp=true format=time ! videoconvert ! video/x-raw,format=I420"
    factory.set_launch(f"( {source} ! {CODECS[given.codec].format(more=given.more)} )")
    factory.set_shared(True)
    factory.connect("media-configure", camera.configure)
    if given.credentials:
        _protect(server, factory, *given.credentials.read_text(encoding="utf-8").splitlines())
    server.get_mount_points().add_factory("/stream", factory)
    server.attach(None)
    print(server.get_bound_port(), flush=True)
    loop = GLib.MainLoop()
    threading.Thread(target=loop.run, daemon=True).start()
    for line in sys.stdin:
        camera.obey(line)


def _protect(server, factory, user, password):
    auth = GstRtspServer.RTSPAuth.new()
    auth.set_supported_methods(GstRtsp.RTSPAuthMethod.DIGEST)
    token = GstRtspServer.RTSPToken.new()
    token.set_string("media.factory.role", "viewer")
    auth.add_digest(user, password, token)
    server.set_auth(auth)
    rights = GstRtspServer.RTSPPermissions.new()
    rights.add_permission_for_role("viewer", "media.factory.access", True)
    rights.add_permission_for_role("viewer", "media.factory.construct", True)
    factory.set_permissions(rights)


if __name__ == "__main__":
    main()
