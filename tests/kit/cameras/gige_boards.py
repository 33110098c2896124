"""Two fake GigE cameras that see boards, and `hotgauge capture` before them; runs in a network of its own.

python gige_boards.py BOARDS OUTPUT
"""

import contextlib
import os
import subprocess
import sys
from pathlib import Path

from running import HOTGAUGE
from shown_boards import HEIGHT_WORDS, capture_poses

POSES = 7
CAMERAS = {"GV01": ("127.0.0.1", "left"), "GV02": ("127.0.0.2", "right")}
CONFIG = """
[sizing.camera]
kind = "genicam"
left = "GV01"
right = "GV02"
region = [0, 0, 800, 600]
rate_hz = 10.0
exposure_us = 3000.0
[sizing.liveness]
apart_max_us = 60000
"""


@contextlib.contextmanager
def gige_camera(serial, folder, held_s, log=os.devnull):
    address, side = CAMERAS[serial]
    script = Path(__file__).with_name("gige_camera.py")
    words = [sys.executable, script, address, serial, "--show", folder / side, str(held_s), "--log", log]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout.readline() == "ready\n"
            yield process.stdin
        finally:
            process.kill()


def capture(*words):
    subprocess.run([HOTGAUGE, "capture", *map(str, words)], check=True, timeout=60)


def main():
    boards, output = map(Path, sys.argv[1:])
    config = output / "gige.toml"
    config.write_text(CONFIG)
    with gige_camera("GV01", boards / "00", 1) as left, gige_camera("GV02", boards / "00", 1) as right:

        def show(pose):
            for orders, side in ((left, "left"), (right, "right")):
                orders.write(f"show {boards / pose / side} 1\n")
                orders.flush()

        print(capture_poses(output / "rig", config, POSES, show), flush=True)
        for height in ("low", "high"):
            show(height)
            words = ["--output", output / "rig", *HEIGHT_WORDS, "--height", height, "--config", config]
            capture("registration", *words)
        capture("recording", "--output", output / "recording", "--seconds", 1, "--config", config)


if __name__ == "__main__":
    main()
