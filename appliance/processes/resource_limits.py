"""Limits of a measuring process: its memory, and its place in the kernel's order when memory runs out."""

import contextlib
import faulthandler
import resource
from pathlib import Path

EXIT_OUT_OF_MEMORY = 12  # exit code; the number of ENOMEM
OOM_SCORE = "500"  # chosen, of 1000: the kernel kills a station before the supervisor, whose score is 0


def limit_process(memory_max_mb: int) -> None:
    """Bound this process's memory, have the kernel kill it before the supervisor, and print tracebacks of crashes.

    Parameters
    ----------
    memory_max_mb : int
        Data, heap and stacks, MB (RLIMIT_DATA); an allocation above it fails. Child processes inherit the bound.
    """
    faulthandler.enable()
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    wanted = memory_max_mb << 20
    resource.setrlimit(resource.RLIMIT_DATA, (wanted if hard < 0 else min(wanted, hard), hard))
    with contextlib.suppress(OSError):  # kernels without OOM scores lack the file
        Path("/proc/self/oom_score_adj").write_text(OOM_SCORE, encoding="ascii")
