"""Kill -9 of the process that writes the history, at 200 random moments, on one and the same file."""

import random
import tempfile
from pathlib import Path

from killed_writer import write_and_kill

TEXT = (
    "A process writes the history as fast as it can, three rows in a transaction, and is killed at a random moment "
    "within 0.3 s; the next one goes on in the same file. Rows whose commit had returned and that are lost, rows that "
    "are there twice, parts of transactions, and files that SQLite does not find in order."
)
REPEATABLE = False  # how many rows are written depends on the computer
KILLS = 200
LATEST_S = 0.3


def cases():
    return [{"kills": KILLS, "seed": 1}]


def run(case):
    source = random.Random(case["seed"])
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "history.db"
        found = [write_and_kill(file, source.uniform(0, LATEST_S)) for _ in range(case["kills"])]
    return {
        "kills": len(found),
        "rows": found[-1].rows,
        "lost": sum(one.lost for one in found),
        "twice": sum(one.twice for one in found),
        "partial": sum(one.partial for one in found),
        "damaged": sum(not one.whole for one in found),
    }


def summary(rows):
    return rows[0]
