"""The gauge's own commands as programs of the page: measuring goes first."""

import sys
from collections.abc import Sequence
from pathlib import Path

NICENESS = "10"


def low_priority_command(words: Sequence[str | Path]) -> list[str | Path]:
    """Command line of `hotgauge` with these words, at low priority."""
    return ["nice", "-n", NICENESS, sys.executable, "-P", "-m", "appliance", *words]
