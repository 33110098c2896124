"""Catches what a library in C prints while it decodes: of damage it says so there and nowhere else."""

import contextlib
import os
import threading
from collections.abc import Generator

_one_at_a_time = threading.Lock()  # there is one standard error in a process


@contextlib.contextmanager
def native_messages() -> Generator[list[str]]:
    """Catch standard error for a moment; the list yielded holds its lines afterwards."""
    lines: list[str] = []
    with _one_at_a_time, contextlib.ExitStack() as places:
        try:
            standard = os.dup(2)
        except OSError:  # closed: nobody reads it, and nothing can be caught
            yield lines
            return
        places.callback(os.close, standard)
        caught = os.memfd_create("messages")
        places.callback(os.close, caught)
        os.dup2(caught, 2)
        try:
            yield lines
        finally:
            os.dup2(standard, 2)
            lines += os.pread(caught, os.fstat(caught).st_size, 0).decode(errors="replace").splitlines()
