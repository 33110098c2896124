"""Compiles what measuring needs before the gauge starts: `python -m appliance.service.compiled_code`.

numba keeps compiled code beside the sources, or in `NUMBA_CACHE_DIR` if set, for every later process of this computer.
"""

import numpy as np

from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.sizing.stereo.gauge import pair_gauge
from vision.edges.operators import detect_edges
from vision.edges.thinning import ridges

SEED = 1  # of the simulated mill; any does


def compile_all() -> None:
    """Calibrate the simulated mill, measure a drawn bar by both routes, and detect edges as the conveyor does."""
    pair_gauge(mill_rig(MillSource(SEED, rate_hz=0)), "the simulated mill", None).warm_up()
    edges = detect_edges(np.zeros((64, 64), np.float32), "forest")
    ridges(edges.strength, edges.normal_rad)


if __name__ == "__main__":
    compile_all()
