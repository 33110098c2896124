"""Whether two versions of the gauge give the same readings, to the last bit.

The first run writes every number that the gauge gives on drawn and recorded pairs; a run of another version sets its
own beside those. It prints how many differ, and by how much at most, and ends with 1 if a reason or a count does, or a
value by more than rounding.
"""

import argparse
import json
import math
import sys
from dataclasses import asdict
from pathlib import Path

from calibrated_rigs import off_response, rig_with_marks
from coded_pictures import CODINGS

from appliance.cameras.recording.pairs import Recording
from appliance.simulation.bars.study_scenes import draw
from appliance.sizing.stereo.rig_file import load_rig
from vision.sizing.gauge import Gauge

CONDITIONS = ("clean", "scale", "post", "glare", "overexposed", "bar-end", "rollers", "haze", "two-bars", "no-bar")
EFFECTS = ("ovality", "camber", "shimmer", "bounce", "nudged")
SENT = tuple(CODINGS)[:: max(1, len(CODINGS) // 6)]
SEEDS = range(30)
FUSED = {"fft": range(3), "db4": range(3)}
ROUNDING_SHARE = 1e-7  # chosen: sums in another order differ by less, and no digit of a register does
LEAST_SIZE = 1e-3  # chosen: mm or pixels; a value that is all but zero differs by its rounding


def drawn():
    """Rigs, their pairs and how they are fused: simulated scenes, grey, coloured and coded."""
    for seed in SEEDS:
        effects = (EFFECTS[seed % len(EFFECTS)],) if seed % 2 else ()
        scene = draw(CONDITIONS[seed % len(CONDITIONS)], seed, effects=effects)
        pair = [off_response(picture, seed) for picture in (scene.left, scene.right)]
        if seed % 3 == 1:
            pair = [picture[:, :, 2].copy() for picture in pair]
        elif seed % 3 == 2:
            coding = CODINGS[SENT[seed % len(SENT)]]
            pair = [coding.sent([picture] * coding.frames) for picture in pair]
        yield rig_with_marks(seed), [pair], "none"
    for method, seeds in FUSED.items():
        for seed in seeds:
            scene = draw("clean", seed)
            yield rig_with_marks(seed), [(scene.left, scene.right)], method


def recorded(folders):
    """Pairs of recorded scenes, each folder with its calibration in `rig.json`."""
    for folder in folders:
        for scene in sorted(folder.glob("scenes/*")):
            yield load_rig(folder / "rig.json"), [(left, right) for _, left, right in Recording(scene)], "none"


def readings(inputs):
    """Every field of every reading, scene by scene."""
    for rig, pairs, fusion in inputs:
        gauge = Gauge(rig, fusion=fusion)
        yield [[asdict(one) for one in gauge.measure_bars(*pair)] for pair in pairs]


def differences(before, after):
    """For each value that differs, by which share of its size; infinite where it is no number or only one is."""
    if isinstance(before, dict):
        return [part for key in before for part in differences(before[key], after[key])]
    if isinstance(before, list):
        if len(before) != len(after):
            return [math.inf]
        return [part for pair in zip(before, after, strict=True) for part in differences(*pair)]
    if not (isinstance(before, float) and isinstance(after, float)):
        return [] if before == after else [math.inf]
    if before == after or (math.isnan(before) and math.isnan(after)):
        return []
    share = abs(before - after) / max(abs(before), LEAST_SIZE)
    return [math.inf if math.isnan(share) else share]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="where the readings of the first run are kept")
    parser.add_argument("recordings", type=Path, nargs="*", help="folders with `scenes` and `rig.json`")
    given = parser.parse_args()
    now = list(readings([*drawn(), *recorded(given.recordings)]))
    if not given.file.exists():
        given.file.write_text(json.dumps(now), encoding="utf-8")
        return 0
    before = json.loads(given.file.read_text(encoding="utf-8"))
    apart = [differences(*scene) for scene in zip(before, json.loads(json.dumps(now)), strict=True)]
    everything = [part for scene in apart for part in scene]
    worst = max(everything, default=0.0)
    print(
        f"{len(before)} scenes, {sum(map(len, before))} pairs: {len(everything)} values differ, at most by {worst:.1e}"
    )
    for number, scene in enumerate(apart):
        if max(scene, default=0.0) > ROUNDING_SHARE:
            print(f"scene {number}: {max(scene):.1e}")
    return int(worst > ROUNDING_SHARE)


if __name__ == "__main__":
    sys.exit(main())
