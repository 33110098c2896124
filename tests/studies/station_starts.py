"""A thousand starts and crashes of a measuring process under the supervisor's keeper."""

import tempfile
from pathlib import Path

from station_cycles import cycles, without_pauses

TEXT = (
    "Starts of a measuring process that gives one reading and is then killed, one after the other without pauses. "
    "Descriptors, children and memory of the process that keeps it, before and after."
)
REPEATABLE = False  # times are those of the computer
COUNT = 1000


def cases():
    return [{"starts": COUNT}]


def run(case):
    without_pauses(setattr)
    with tempfile.TemporaryDirectory() as folder:
        return cycles(case["starts"], Path(folder))


def summary(rows):
    return rows[0]
