"""Sentences that state how fast the gauge is, and what a reading owes to the frames before it."""

from results import Numbers, Sentence, Summary, summary


def _frames_before() -> Numbers:
    found = summary("frames_before")
    kinds = ("frames", "values_that_a_search_refuses", "values_that_are_missed")
    return tuple(str(found[kind]) for kind in kinds)


def _at_full_rate() -> Numbers:
    """Of each size and time: pairs, what was dropped, latency, processor, memory."""
    return tuple(str(number) for one in summary("end_to_end").values() for number in _of_a_rate(one))


def _of_a_rate(one: Summary) -> tuple[float, ...]:
    station_mb = [sample["station"] for sample in one["memory_mb"]]
    names = ("pairs", "dropped", "latency_p50_ms", "latency_p99_ms", "processor_percent")
    return (*(one[name] for name in names), station_mb[0], station_mb[-1], one["station_peak_mb"])


def _start_times() -> Numbers:
    seconds = summary("start_times")
    return tuple(f"{seconds[name][of]:.1f}" for name in ("warm", "killed", "cold") for of in ("median_s", "worst_s"))


BENCHMARKS = "benchmarks/README.md"
SPEED_SENTENCES = (
    Sentence(
        "docs/methods/diameter.md",
        _frames_before,
        "Of {} frames {} had a value that a new gauge, which sees the pair alone, refuses, {} had none where it has "
        "one",
    ),
    Sentence(
        BENCHMARKS,
        _at_full_rate,
        "at 800 x 600, 25 a second, {} pairs came and {} were dropped, median and 99 % of the latency were {} and {} "
        "ms, both processes took {} % of one core, the station held {} MB at first, {} at last and {} at most; at "
        "2704 x 1520, 5 a second, {} pairs, {} dropped, {} and {} ms, {} %, {}, {} and {} MB; an hour of it, beside "
        "other work that took more than the rest of the computer: {} pairs, {} dropped, {} and {} ms, {} %, {}, {} and "
        "{} MB",
    ),
    Sentence(
        BENCHMARKS,
        _start_times,
        "after {} s (median of five; worst {}), again after {} s (worst {}) when its measuring process was killed. "
        "With nothing compiled it takes {} s (worst {})",
    ),
)
