"""The appliance: cameras to vision to PLC, everything with a clock, a file or a socket."""

import os

# The matrices here are small. On two busy cores a second thread of the linear algebra library waits by spinning,
# and makes a calibration of 0.1 s last 3 s. The library reads this once, when numpy is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Read by the C library when a process starts, so by the stations that the supervisor starts: with one heap for all
# threads a station holds 13 to 29 MB less and computes no slower (benchmarks/README.md).
os.environ.setdefault("MALLOC_ARENA_MAX", "1")
