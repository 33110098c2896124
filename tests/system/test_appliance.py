"""The whole appliance as a process, on the simulated mill, seen by a PLC whose connection stays open."""

import itertools
import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from modbus_wire import Wire
from plc_view import Values, has_none, has_value, look, look_at_bits, wait_for
from running import Appliance, free_port, gone_within, running
from torn_reads import agrees_with_itself, count_torn

from appliance.simulation.bars.bars import bar_at
from vision.reasons import Reason

SEED = 5
BARS_MM = [bar.diameter_mm for frame in range(0, 3000, 50) if (bar := bar_at(SEED, frame)) is not None]


def settings(folder: Path, port: int) -> Path:
    file = folder / "hotgauge.toml"
    file.write_text(f'[plc]\nport = {port}\n[sizing.camera]\nkind = "mill"\nseed = {SEED}\n')
    return file


@pytest.fixture(scope="module")
def appliance(tmp_path_factory) -> Iterator[Appliance]:
    port = free_port()
    file = settings(tmp_path_factory.mktemp("appliance"), port)
    with running("run", "--config", file, port=port) as appliance:
        yield appliance


@pytest.fixture
def wire(appliance) -> Iterator[Wire]:
    with appliance.wire() as wire:
        wait_for(wire, has_value, 20)
        yield wire


class Scan:
    """Polls every 20 ms on one connection, from a thread, and remembers everything."""

    def __init__(self, appliance: Appliance) -> None:
        self.seen: list[tuple[float, Values]] = []
        self.lost: Exception | None = None
        self._wire = appliance.wire()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> "Scan":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        self._wire.socket.close()

    def first(self, since_s: float, wanted, within_s: float) -> float:
        """Seconds from `since_s` to the first block that is as wanted."""
        while time.monotonic() < since_s + within_s + 0.1:
            for moment_s, seen in list(self.seen):
                if moment_s >= since_s and wanted(seen):
                    assert moment_s - since_s <= within_s
                    return moment_s - since_s
            time.sleep(0.02)
        raise AssertionError(f"not seen within {within_s} s; last: {self.seen[-1]}")

    def _run(self) -> None:
        try:
            while not self._over.wait(0.02):
                moment_s = time.monotonic()
                self.seen.append((moment_s, look(self._wire)))
        except OSError as error:
            self.lost = error


def test_diameters_are_valid_true_and_change_from_bar_to_bar(appliance, wire):
    with Scan(appliance) as scan:
        time.sleep(12)
    diameters = [seen["diameter"] for _, seen in scan.seen if has_value(seen)]
    assert len(diameters) > len(scan.seen) / 2
    assert max(min(abs(diameter - bar) for bar in BARS_MM) for diameter in diameters) < 0.3
    assert len({round(diameter) for diameter in diameters}) >= 2
    assert all(seen["sequence"] == seen["sequence_check"] for _, seen in scan.seen)
    assert all((seen["diameter"] is None) == has_none(seen) for _, seen in scan.seen)
    bits = look_at_bits(wire)
    assert bits["simulated"]
    assert bits["running"]


def test_the_sequence_moves_with_each_reading_and_stands_in_between(appliance, wire):
    with Scan(appliance) as scan:
        time.sleep(3)
    pairs = [(seen["sequence"], seen["timestamp"], seen["diameter"]) for _, seen in scan.seen]
    for before, after in itertools.pairwise(pairs):
        assert (before == after) == (before[0] == after[0])
        assert 0 <= after[0] - before[0] <= 3


def test_the_heartbeat_moves_ten_times_a_second_and_never_rests(appliance, wire):
    with Scan(appliance) as scan:
        time.sleep(5)
    (begun_s, first), (ended_s, last) = scan.seen[0], scan.seen[-1]
    assert last["heartbeat"] - first["heartbeat"] == pytest.approx((ended_s - begun_s) / 0.1, abs=2)
    changed_s = [after_s for (_, a), (after_s, b) in itertools.pairwise(scan.seen) if a != b]
    assert max(b - a for a, b in itertools.pairwise(changed_s)) < 0.3


def test_the_age_is_that_of_the_exposure(wire):
    for _ in range(50):
        seen = look(wire)
        true_age_ms = time.time() * 1000 - seen["timestamp"]
        assert -5 <= true_age_ms - seen["measurement_age"] < 200  # the swap was at most 100 ms ago on an idle computer
        time.sleep(0.02)


def test_no_read_is_torn_while_the_appliance_measures(appliance, wire):
    blocks = count_torn(appliance.port, 20, agrees_with_itself)
    assert blocks.read > 1000
    assert blocks.torn == 0


def test_a_killed_measuring_process_costs_no_connection_and_is_back_in_time(appliance, wire):
    killed = appliance.station()
    with Scan(appliance) as scan:
        time.sleep(0.2)
        killed_s = time.monotonic()
        os.kill(killed, signal.SIGKILL)
        off_s = scan.first(killed_s, lambda seen: seen["reason_word"] == Reason.STARTING, 1)
        back_s = scan.first(killed_s + off_s, has_value, 10)
        time.sleep(0.5)
    print(f"validity off after {off_s:.3f} s, measuring again after {off_s + back_s:.2f} s")
    assert scan.lost is None
    off = [seen for moment_s, seen in scan.seen if killed_s + off_s <= moment_s < killed_s + off_s + back_s]
    for seen in off:
        assert seen["diameter"] is None
        assert seen["diameter_u16"] is None
        assert seen["device_state"] in (3, 4)
    assert off[0]["device_state"] == 4
    beats = [seen["heartbeat"] for _, seen in scan.seen]
    assert max(b - a for a, b in itertools.pairwise(beats)) <= 3
    assert appliance.station() != killed


def test_a_stopped_measuring_process_leaves_no_value_standing(appliance, wire):
    station = appliance.station()
    stopped_s = time.monotonic()
    os.kill(station, signal.SIGSTOP)
    try:
        seen = wait_for(wire, lambda seen: bool(seen["reason_word"] & Reason.STALE), 1)
        assert time.monotonic() - stopped_s <= 1
        assert seen["diameter"] is None
        assert has_none(seen)
        assert look_at_bits(wire)["alarm_stale"]
    finally:
        os.kill(station, signal.SIGCONT)
    wait_for(wire, has_value, 5)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_stop_is_clean_and_takes_the_measuring_process_along(tmp_path, number):
    port = free_port()
    with running("run", "--config", settings(tmp_path, port), port=port) as appliance:
        station = appliance.station()
        appliance.process.send_signal(number)
        assert appliance.process.wait(5) == 0
        assert gone_within(station, 0.1)


def test_a_measuring_process_does_not_outlive_its_supervisor(tmp_path):
    port = free_port()
    with running("run", "--config", settings(tmp_path, port), port=port) as appliance:
        station = appliance.station()
        appliance.process.kill()
        assert gone_within(station, 4)
