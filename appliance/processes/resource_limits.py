"""What a measuring process may not do to the rest of the computer, and what it says when it dies."""

import contextlib
import faulthandler
import resource
from pathlib import Path

EXIT_OUT_OF_MEMORY = 12  # ENOMEM
OOM_SCORE = "500"  # of 1000: before the supervisor, when the computer's memory is full


def limit_process(memory_max_mb: int) -> None:
    """Bound this process's memory, offer it first when the computer's is full, and name the place of native crashes.

    Parameters
    ----------
    memory_max_mb : int
        Data, heap and stacks; an allocation above it fails. Processes that this one starts have the same bound.
    """
    faulthandler.enable()
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    wanted = memory_max_mb << 20
    resource.setrlimit(resource.RLIMIT_DATA, (wanted if hard < 0 else min(wanted, hard), hard))
    with contextlib.suppress(OSError):  # a kernel without the file
        Path("/proc/self/oom_score_adj").write_text(OOM_SCORE, encoding="ascii")
