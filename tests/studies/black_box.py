"""What the black box costs measuring: time of a pair without it, with it in memory, and while it writes."""

import dataclasses
import shutil
import statistics
import tempfile
import time
from pathlib import Path

from mill_scenes import perfect_rig

from appliance.black_box import black_box
from appliance.black_box.black_box import BlackBox
from appliance.black_box.settings import BlackBoxSettings
from appliance.cameras.simulated.pairs import MillSource
from appliance.simulation.true_rig import default_rig
from appliance.sizing.stereo.gauge import TimedGauge
from vision.sizing.gauge import Gauge

TEXT = (
    "Pairs of the simulated mill are measured one after the other at 8 a second, in turns of eight seconds: without a "
    "black box, with one that keeps pictures in memory, and with one that writes them all the time. Computing time "
    "of a pair, ms."
)
REPEATABLE = False  # times are those of the computer
TURNS = 4
TURN_S = 8.0
RATE_HZ = 8.0
KINDS = ("without", "in memory", "while writing")


def cases():
    return [{"turns": TURNS}]


def run(case):
    gauge = TimedGauge(perfect_rig(default_rig()), "a simulated rig", Gauge)
    gauge.warm_up()
    with MillSource(seed=1, rate_hz=0) as source:
        pairs = [source.next(10) for _ in range(24)]
    black_box.AFTER_S = 0.1
    times = {kind: [] for kind in KINDS}
    written = 0
    for _ in range(case["turns"]):
        for kind in KINDS:
            folder = Path(tempfile.mkdtemp())
            box = BlackBox(BlackBoxSettings(directory=folder if kind != "without" else None, again_after_s=0), "sizing")
            times[kind] += _turn(gauge, pairs, box, writes=kind == "while writing")
            box.close()
            written += len(list(folder.glob("2*")))
            shutil.rmtree(folder)
    found = {"recordings_written": written}
    for kind, elapsed in times.items():
        name = kind.replace(" ", "_")
        found[f"{name}_median_ms"] = round(statistics.median(elapsed), 1)
        found[f"{name}_p95_ms"] = round(statistics.quantiles(elapsed, n=20)[-1], 1)
    return found


def _turn(gauge, pairs, box, *, writes):
    elapsed = []
    begun_s = time.monotonic()
    number = 0
    while time.monotonic() - begun_s < TURN_S:
        pair = pairs[number % len(pairs)]
        _, elapsed_ms = gauge.measure(*pair.pictures)
        box.add(dataclasses.replace(pair, exposed_monotonic_s=time.monotonic()), list)
        elapsed.append(elapsed_ms)
        if writes and number % 4 == 0:
            box.keep(f"request {number}")
        number += 1
        time.sleep(max(0.0, begun_s + number / RATE_HZ - time.monotonic()))
    return elapsed


def summary(rows):
    return rows[0]
