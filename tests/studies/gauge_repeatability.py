"""The gauge study: the same bar at the same place, 24 pictures that differ by their noise alone."""

import numpy as np
from calibrated_rigs import off_response, rig_with_marks

from appliance.simulation.bars.study_scenes import set_up
from studies.served_diameter import rounded
from vision.sizing.gauge import Gauge
from vision.sizing.passing_bar import PassingBar

TEXT = (
    "The gauge as served; the same bar and place, 24 noises; rigs and calibrations as in served_diameter, 800 x 600. "
    "Shimmer displaces the picture anew in each frame, beside the noise. Of a tolerance 4 mm wide: six standard "
    "deviations of the 24 values over 4 mm. The bar's value: three of each bar, each of eight frames."
)
CONDITIONS = {"clean": (), "haze": (), "shimmer": ("shimmer",)}
SEEDS = range(1000, 1006)
FRAMES = 24
FRAMES_OF_BAR = 8  # a bar that passes in a third of a second at 25 frames a second
FRAME_PERIOD_S = 0.04
SAMPLE = 1
TOLERANCE_MM = 4.0


def cases():
    return [{"condition": name, "seed": seed} for seed in SEEDS for name in CONDITIONS]


def run(case):
    name, seed = case["condition"], case["seed"]
    effects = CONDITIONS[name]
    setup = set_up("clean" if effects else name, seed, effects=effects)
    gauge = Gauge(rig_with_marks(seed), 0.0)
    readings = [gauge.measure(*(off_response(one, seed) for one in setup.pair(frame))) for frame in range(FRAMES)]
    value_mm = np.array([reading.diameter_mm for reading in readings if reading.valid])
    virtual_mm = np.array([reading.diameter_virtual_board_mm for reading in readings])
    return {
        "values": len(value_mm),
        "truth_mm": setup.diameter_mm,
        "mean_error_mm": rounded(value_mm.mean() - setup.diameter_mm),
        "sigma_mm": rounded(value_mm.std(ddof=1)),
        "sigma_bar_mm": rounded(np.std([bar_value_mm(group) for group in groups(readings)], ddof=1)),
        "u_edge_mm": rounded(np.mean([reading.u_edge_mm for reading in readings if reading.valid])),
        "sigma_virtual_board_mm": rounded(np.std(virtual_mm[np.isfinite(virtual_mm)], ddof=1)),
    }


def groups(readings):
    return [readings[first : first + FRAMES_OF_BAR] for first in range(0, FRAMES, FRAMES_OF_BAR)]


def bar_value_mm(readings):
    bar = PassingBar()
    return [bar.add(one, FRAME_PERIOD_S * frame) for frame, one in enumerate(readings)][-1].bar_diameter_mm


def summary(rows):
    return {name: _of_condition([row for row in rows if row["condition"] == name]) for name in CONDITIONS}


def _of_condition(rows):
    sigma = np.array([row["sigma_mm"] for row in rows])
    together = np.sqrt(np.mean(sigma**2))
    bar = np.sqrt(np.mean([row["sigma_bar_mm"] ** 2 for row in rows]))
    return {
        "bars": len(rows),
        "values_of_24": min(row["values"] for row in rows),
        "sigma_mm": rounded(together),
        "worst_sigma_mm": rounded(sigma.max()),
        "of_tolerance_percent": rounded(100 * 6 * together / TOLERANCE_MM),
        "worst_of_tolerance_percent": rounded(100 * 6 * sigma.max() / TOLERANCE_MM),
        "sigma_bar_mm": rounded(bar),
        "bar_of_tolerance_percent": rounded(100 * 6 * bar / TOLERANCE_MM),
        "u_edge_mm": rounded(np.sqrt(np.mean([row["u_edge_mm"] ** 2 for row in rows]))),
        "sigma_virtual_board_mm": rounded(np.sqrt(np.mean([row["sigma_virtual_board_mm"] ** 2 for row in rows]))),
    }
