"""One camera between barriers, end to end: the appliance on the simulated thermal line, read as a PLC reads it."""

import time

import pytest
from plc_view import look, wait_for
from running import free_port, running

from appliance.simulation.bars.bars import Bar, bar_at
from appliance.simulation.thermal_line import ThermalLine, thermal_camera
from appliance.simulation.write_recording import write_thermal_recording
from plc.poll import poll

pytestmark = pytest.mark.waiting

SEED = 11
SETTINGS = """
[plc]
port = {port}
[sizing]
method = "conveyor"
stale_after_ms = 10000  # a busy computer may be late; lateness has tests of its own
[sizing.liveness]
idle_after_s = 120
[sizing.conveyor]
barrier_mm = 600
barrier_height_mm = 100
response_exponent = 1
[sizing.camera]
kind = "mill"
seed = {seed}
rate_hz = 10
"""


def test_a_plc_reads_the_diameter_of_the_bar_that_passes(tmp_path):
    port = free_port()
    file = tmp_path / "hotgauge.toml"
    file.write_text(SETTINGS.format(port=port, seed=SEED))
    with running("run", "--config", file, port=port) as appliance, appliance.wire() as wire:
        wait_for(wire, lambda seen: seen["validity"] != 0, 40)
        started = time.monotonic()
        diameters = {bar.diameter_mm for frame in range(1200) if (bar := bar_at(SEED, frame))}
        served = []
        while time.monotonic() - started < 8:
            seen = look(wire)
            if seen["validity"]:
                served.append(seen)
            time.sleep(0.1)
        for seen in served:
            error_mm = min(abs(seen["diameter"] - diameter_mm) for diameter_mm in diameters)
            assert error_mm <= seen["expanded_uncertainty"]
            assert seen["expanded_uncertainty"] < 1
            assert seen["windows_total"] == 24
            assert seen["diameter_virtual_board"] is None
            assert seen["weighted_deviation"] is None
            assert 0 < seen["trust"] <= 100
        assert len(served) > 20
        assert len({round(seen["diameter"]) for seen in served}) >= 2, "bars pass, and the value goes with them"
        snapshot = next(iter(poll("127.0.0.1", port)))
        assert snapshot.values["device_state"] == 3


def test_a_replayed_recording_gives_the_diameter_of_its_bar(tmp_path):
    port = free_port()
    file = tmp_path / "hotgauge.toml"
    file.write_text(SETTINGS.format(port=port, seed=SEED).replace("barrier_mm = 600", "barrier_mm = 500"))
    line = ThermalLine(thermal_camera(2700.0, aside_deg=3.0), bar=Bar(180.0, -40.0), seed=5)
    write_thermal_recording(tmp_path / "line", line, empty=4, frames=10)
    with running("replay", tmp_path / "line", "--config", file, port=port) as appliance, appliance.wire() as wire:
        seen = wait_for(wire, lambda seen: seen["validity"] != 0, 40)
        assert abs(seen["diameter"] - 180.0) <= seen["expanded_uncertainty"] < 1
        seen = wait_for(wire, lambda seen: seen["validity"] == 0, 10)
        assert seen["diameter"] is None, "the empty line has none"
