"""A GigE Vision camera on loopback that shows pictures of a folder: Aravis' fake camera, with pictures of our own.

    python gige_camera.py 127.0.0.1 GV01 --show FOLDER SECONDS

Obeys `show FOLDER SECONDS` on its standard input. Pictures of 8 bits only; the receiver's region must have their size.
"""

import argparse
import ctypes
import sys

import gi
from clock_picture import now_ms
from shown_pictures import ShownPictures

gi.require_version("Aravis", "0.8")

from gi.repository import Aravis  # noqa: E402  GObject wants its versions first

LIBRARY = ctypes.CDLL("libaravis-0.8.so.0")
# a callback that GObject wraps would wait for Python's main thread for ever
FILL = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32)
LIBRARY.arv_buffer_get_data.restype = ctypes.c_void_p
LIBRARY.arv_buffer_get_data.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
LIBRARY.arv_fake_camera_set_fill_pattern.argtypes = [ctypes.c_void_p, FILL, ctypes.c_void_p]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("address")
    parser.add_argument("serial")
    parser.add_argument("--show", nargs=2, metavar=("FOLDER", "SECONDS"), required=True)
    parser.add_argument("--log", type=argparse.FileType("w"))
    given = parser.parse_args()
    shown = ShownPictures(given.show[0], float(given.show[1]), given.log)

    @FILL
    def fill(buffer, _data, _exposure_us, _gain, _pixel_format):
        picture = shown.at(now_ms()).tobytes()
        ctypes.memmove(LIBRARY.arv_buffer_get_data(buffer, None), picture, len(picture))

    camera = Aravis.GvFakeCamera.new(given.address, given.serial)
    LIBRARY.arv_fake_camera_set_fill_pattern(hash(camera.get_fake_camera()), fill, None)
    print("ready", flush=True)
    for line in sys.stdin:
        _, folder, held_s = line.split()
        shown.show(folder, float(held_s))


if __name__ == "__main__":
    main()
