"""Starts and ends of a measuring process, again and again, and what they leave behind."""

import asyncio
import gc
import os
import time
from pathlib import Path

from messages import reading
from station_path import STATION_PATH

from appliance.processes import monitored_process as keeper
from appliance.processes.monitored_process import Health, MonitoredProcess
from appliance.sizing.message import MESSAGES

WARM_UP = 10


def cycles(count: int, folder: Path) -> dict[str, object]:
    """Let a process start, give a reading and crash `count` times; descriptors, children and memory before and after.

    The keeper's pauses are taken out by the caller.
    """
    (folder / "reading").write_bytes(reading().model_dump_json().encode() + b"\n")
    os.environ["BLINKING_STATION"] = str(folder / "reading")
    os.environ["PYTHONPATH"] = STATION_PATH
    return asyncio.run(_count(count))


async def _count(count: int) -> dict[str, object]:
    seen = {"readings": 0, "ends": 0}
    looks: list[tuple[int, int, int]] = []
    over = asyncio.Event()

    def hear(_: object) -> None:
        seen["readings"] += 1

    def tell(health: Health) -> None:
        seen["ends"] += health.ended
        if seen["ends"] == WARM_UP:
            looks.append(footprint())
        if seen["ends"] == WARM_UP + count:
            looks.append(footprint())
            over.set()

    begun_s = time.monotonic()
    task = asyncio.create_task(MonitoredProcess("blinking_station", "{}", MESSAGES, hear, tell).run())
    await asyncio.wait({task, asyncio.create_task(over.wait())}, return_when=asyncio.FIRST_COMPLETED)
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)
    (descriptors, children, rss_kb), (descriptors_after, children_after, rss_after_kb) = looks
    return {
        **seen,
        "seconds_each": round((time.monotonic() - begun_s) / (WARM_UP + count), 3),
        "descriptors": [descriptors, descriptors_after],
        "children": [children, children_after],
        "rss_kb": [rss_kb, rss_after_kb],
    }


def footprint() -> tuple[int, int, int]:
    gc.collect()
    children = [child for task in Path("/proc/self/task").glob("*/children") for child in task.read_text().split()]
    status = Path("/proc/self/status").read_text().splitlines()
    rss_kb = next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))
    return len(list(Path("/proc/self/fd").iterdir())), len(children), rss_kb


def without_pauses(set_attribute) -> None:
    """Let the keeper start again at once; `set_attribute` as of monkeypatch."""
    for name in ("FIRST_PAUSE_S", "LONGEST_PAUSE_S", "FAILING_PAUSE_S"):
        set_attribute(keeper, name, 0.0)
