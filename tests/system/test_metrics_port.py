"""A running gauge serves its figures to Prometheus, and a killed process that delivers them comes back."""

import os
import signal
import urllib.request
from pathlib import Path

from modbus_wire import eventually
from plc_view import has_value, look, wait_for
from rehearsal import rehearsing
from running import free_port

from appliance.delivery.settings import MetricsSettings
from appliance.supervisor.supervisor import Supervisor


def figures(port: int) -> dict[str, float]:
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=5) as answer:
            lines = answer.read().decode().splitlines()
    except OSError:
        return {}
    return {line.rpartition(" ")[0]: float(line.rpartition(" ")[2]) for line in lines if not line.startswith("#")}


def delivering() -> list[int]:
    """Process ids of what delivers for this test."""
    tasks = Path("/proc/self/task").glob("*/children")
    children = [int(child) for task in tasks for child in task.read_text().split()]
    return [one for one in children if b"appliance.delivery.process" in Path(f"/proc/{one}/cmdline").read_bytes()]


def test_figures_are_those_of_the_registers_also_after_their_process_was_killed(tmp_path, monkeypatch):
    port = free_port()
    with rehearsing("fake_station", tmp_path, monkeypatch) as rehearsal:
        rehearsal.settings = rehearsal.settings.model_copy(update={"metrics": MetricsSettings(port=port)})
        rehearsal.supervisor = Supervisor(rehearsal.settings)
        rehearsal.start()
        with rehearsal.connect() as wire:
            wait_for(wire, has_value, 5)
            assert eventually(lambda: 200 <= figures(port).get("hotgauge_diameter_mm", 0) < 250, 20)
            before = figures(port)["hotgauge_heartbeat"]
            assert eventually(lambda: figures(port)["hotgauge_heartbeat"] > before, 5)
            (process,) = delivering()
            os.kill(process, signal.SIGKILL)
            assert has_value(look(wire))
            assert eventually(lambda: figures(port).get("hotgauge_heartbeat", 0) > before, 20)
            assert figures(port)['hotgauge_fault{fault="delivery_failed"}'] == 0
