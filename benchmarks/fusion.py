"""How long fusing one grey pair takes, beside the plain numpy and PyWavelets way of writing the same.

All ways run in turn on the same pair in one process; the ratio is what to quote, times depend on the machine.
"""

import statistics
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pywt
from mill_scenes import perfect_rig

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig
from vision.alignment.view_alignment import Alignment
from vision.alignment.virtual_boards import VirtualBoards
from vision.fusion.methods import fuse
from vision.geometry.turned_region import whole_picture

SIZES = ((800, 600), (2704, 1520))
ROUNDS = 15
LEVELS = 4
WANTED_MS = {("fft", 800): 3.0, ("db4", 800): 12.0, ("fft", 2704): 60.0}


def plain_fft(left, right):
    first, second = np.fft.fft2(left), np.fft.fft2(right)
    fused = np.where(np.abs(first) > np.abs(second), first, second)
    return np.clip(np.fft.ifft2(fused).real, 0, 255).astype(np.uint8)


def plain_wavelets(left, right):
    first, second = (pywt.wavedec2(picture, "db4", level=LEVELS) for picture in (left, right))
    fused = [(first[0] + second[0]) / 2]
    for bands, others in zip(first[1:], second[1:], strict=True):
        fused.append(tuple(np.where(np.abs(a) > np.abs(b), a, b) for a, b in zip(bands, others, strict=True)))
    rows, columns = left.shape
    return np.clip(pywt.waverec2(fused, "db4")[:rows, :columns], 0, 255).astype(np.uint8)


def aligned_pair(size):
    true_rig = default_rig(size)
    rig = perfect_rig(true_rig)
    pictures = Scene(true_rig, seed=1).pair(Bar(180.0), 0)
    views = [
        whole_picture(camera, np.ascontiguousarray(picture[:, :, 2]))
        for camera, picture in zip((rig.left, rig.right), pictures, strict=True)
    ]
    alignment = Alignment(rig, VirtualBoards.of_rig(rig), *views, projective=True)
    return alignment.left.picture, alignment.right_on_left(100.0)


def timed_ms(work, *arguments):
    started, used = time.perf_counter(), time.process_time()
    work(*arguments)
    return 1000 * (time.perf_counter() - started), 1000 * (time.process_time() - used)


def main():
    with ThreadPoolExecutor(2) as pool:
        for size in SIZES:
            pair = aligned_pair(size)
            for method, plain in (("fft", plain_fft), ("db4", plain_wavelets)):
                compare(method, pair, lambda a, b, m=method: fuse(a, b, m, executor=pool), plain)


def compare(method, pair, ours, plain):
    rows, columns = pair[0].shape
    ours(*pair)
    runs = [(timed_ms(ours, *pair), timed_ms(plain, *pair)) for _ in range(ROUNDS)]
    wall = [statistics.median(run[way][0] for run in runs) for way in (0, 1)]
    used = [min(run[way][1] for run in runs) for way in (0, 1)]
    wanted = WANTED_MS.get((method, columns))
    print(
        f"{columns} x {rows} {method}: {wall[0]:.1f} ms a pair{f' (wanted {wanted:g})' if wanted else ''}, plain "
        f"{wall[1]:.1f} ms, ratio {wall[0] / wall[1]:.2f}; least processor time {used[0]:.1f} and {used[1]:.1f} ms, "
        f"ratio {used[0] / used[1]:.2f}"
    )


if __name__ == "__main__":
    main()
