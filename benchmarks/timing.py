"""Times of two ways of doing the same work, in turn within one run; what a benchmark is made of."""

import statistics
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Self

SLIP_SHARE = 0.15  # chosen: medians of the processor's time differ by less from run to run on a quiet machine
CONTRIB = Path(__file__).parents[1] / ".venv-contrib" / "bin" / "python"


@dataclass(frozen=True, slots=True)
class Times:
    """Time on the clock and of the processor for one call; of two cores the latter may be twice the former."""

    clock_ms: float
    processor_ms: float

    @classmethod
    def median(cls, all_times: list[Self]) -> Self:
        """Of one way over all rounds."""
        return cls(*(statistics.median(getattr(one, part) for one in all_times) for part in cls.__slots__))


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table: our way beside a rival's."""

    work: str
    rival: str
    ours: Times
    theirs: Times

    @property
    def ratios(self) -> tuple[float, float]:
        """How many times longer the rival takes, on the clock and of the processor."""
        return self.theirs.clock_ms / self.ours.clock_ms, self.theirs.processor_ms / self.ours.processor_ms

    def has_slipped(self, kept: dict[str, float]) -> bool:
        """Whether the rival is nearer, by the processor's time, than when the ratios were kept."""
        return self.ratios[1] < (1 - SLIP_SHARE) * kept.get(self.work, 0.0)


def timed(work: Callable, *arguments) -> Times:
    """Run once."""
    clock, processor = time.perf_counter(), time.process_time()
    work(*arguments)
    return Times(1000 * (time.perf_counter() - clock), 1000 * (time.process_time() - processor))


def in_turn(work: str, rival: str, ours: Callable[[int], Times], theirs: Callable[[int], Times], rounds: int) -> Row:
    """Call both ways round by round, once before that count; each is given the number of the round."""
    ours(0), theirs(0)
    times = [(ours(number), theirs(number)) for number in range(rounds)]
    return Row(work, rival, *(Times.median([one[way] for one in times]) for way in (0, 1)))


class Child:
    """A rival in an environment of its own: it prints `ready`, and answers each line by milliseconds."""

    def __init__(self, script: str, *arguments: str | Path) -> None:
        command = [CONTRIB, Path(__file__).with_name(script), *arguments]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)
        if self._process.stdout.readline().strip() != "ready":
            raise SystemExit(f"benchmarks: {script} did not start; `make bench` makes its environment")

    def ask(self, line: str | Path) -> Times:
        """What one call took."""
        self._process.stdin.write(f"{line}\n")
        clock, processor, *_ = self._process.stdout.readline().split()
        return Times(float(clock), float(processor))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with self._process:  # closes its input, at which it ends
            pass
