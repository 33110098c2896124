"""A measuring process keeps what a frame frees for the next one."""

import subprocess
import sys

FRAMES = """
import resource
import numpy as np
from appliance.processes.resource_limits import keep_freed_memory
if {kept}:
    keep_freed_memory()
for frame in range(60):
    if frame == 10:
        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    views = [np.ones((1520, 2704), np.float32) for _ in range(2)]
    del views
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def faults(*, kept: bool) -> int:
    words = [sys.executable, "-c", FRAMES.format(kept=kept)]
    return int(subprocess.run(words, capture_output=True, text=True, check=True, timeout=60).stdout)


def test_pages_that_a_frame_has_freed_cost_no_fault_in_the_next_one():
    assert faults(kept=True) < 0.1 * faults(kept=False)
