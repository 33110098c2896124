"""Compile what measuring and edge detection need, once, before two processes of tests would each do it.

numba keeps compiled code beside the sources, or in `NUMBA_CACHE_DIR` if set; every later process reads it there.
"""

import numpy as np
from mill_scenes import perfect_rig

from appliance.simulation.true_rig import default_rig
from appliance.sizing.stereo.gauge import TimedGauge
from vision.edges.operators import detect_edges
from vision.edges.thinning import ridges
from vision.sizing.gauge import Gauge

if __name__ == "__main__":
    TimedGauge(perfect_rig(default_rig()), "a simulated rig", Gauge).warm_up()
    edges = detect_edges(np.zeros((64, 64), np.float32), "forest")
    ridges(edges.strength, edges.normal_rad)
