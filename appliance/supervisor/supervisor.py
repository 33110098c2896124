"""Owns the PLC's server and keeps it truthful: publishes, watches the measuring process, knows the faults.

Everything here runs in one asyncio loop and waits for nobody: a measuring process that crashes, hangs or
babbles, or a disk that is full, changes what is published, never whether something is.
"""

import asyncio
import contextlib
import logging
import os
import time
from collections.abc import Callable, Mapping

from appliance.conformity.advisor import Advisor
from appliance.conformity.bar_statistics import PerBar
from appliance.conformity.decision import Decision
from appliance.conformity.set_point_store import Kept
from appliance.conformity.set_points import SetPoints
from appliance.diagnostics.alarms import Alarms
from appliance.diagnostics.fault_table import DeviceState
from appliance.diagnostics.faults import Faults
from appliance.processes.link import Message
from appliance.processes.message import StateMessage
from appliance.processes.monitored_process import Health, Keeper
from appliance.settings.file import SettingsError
from appliance.sizing.lasting_reasons import Lasting
from appliance.sizing.message import ReadingMessage
from appliance.sizing.published import NO_PAIR, STARTING, Publication
from appliance.sizing.reading_ring import ReadingRing
from appliance.supervisor.clock_watch import WallClock
from appliance.supervisor.ingot_client import INGOT, IngotSide, is_on
from appliance.supervisor.self_check import SelfCheck
from appliance.supervisor.settings import Settings, state_folder
from plc.process_image import encode
from plc.rows import Value
from plc.server import ModbusServer

SWAP_PERIOD_S = 0.05  # half of the longest allowed, so that a late wake-up stays within it
HEARTBEAT_PERIOD_S = 0.1
LASTING_S = 10.0  # of a reason, before it is the gauge's fault and not the bar's
SIZING_STATION = "appliance.sizing.station"
SIZING = "sizing"
PROOF_PERIOD_S = 0.5

logger = logging.getLogger("hotgauge.supervisor")


class StartRefusedError(Exception):
    """The appliance cannot start with these settings; the message says what, where and what to do."""


class Supervisor:
    """The appliance without its images.

    Parameters
    ----------
    settings : Settings
    """

    def __init__(self, settings: Settings, *, wall: Callable[[], float] = time.time) -> None:
        self._settings = settings
        self._server = ModbusServer(
            settings.plc.host,
            settings.plc.port,
            writes=settings.plc.writes,
            connections_max=settings.plc.connections_max + 1,  # the self-check is one
            on_write=self._hear_plc,
        )
        self._publication = Publication(settings.sizing.stale_after_ms)
        self._advisor = Advisor(settings.judging, settings.correction)
        self._ring = ReadingRing()
        self._bars = PerBar(settings.judging.bar_gap_ms / 1000)
        self._lasting = Lasting(LASTING_S)
        self._faults = Faults()
        self._alarms = Alarms()
        self._kept = Kept(state_folder(settings.plc), self._report_disk)
        self._keeper = Keeper(SIZING_STATION, settings.sizing.model_dump_json(), self._hear, self._hear_health)
        self._ingots = (
            IngotSide(settings.ingot, self._faults, self._tell, self._refuse) if is_on(settings.ingot) else None
        )
        self._silent = {SIZING, INGOT} if self._ingots else {SIZING}  # stations that have not spoken yet
        self._clock = WallClock(wall)
        self._plc_beat_s: float | None = None
        self._started_s = self._worked_s = time.monotonic()
        self._news = asyncio.Event()
        self._serving = asyncio.Event()
        self._stopping = False
        self._measuring = False
        self._simulated = False
        self._refuses = False
        self._refusal = ""

    def stop(self) -> None:
        """Let `run` come to its end."""
        self._stopping = True
        self._news.set()

    async def run(
        self,
        on_serving: Callable[[int], None],
        on_proof: Callable[[str], None] = lambda _: None,
        *,
        refuses: bool = True,
    ) -> None:
        """Measure and serve until `stop`.

        Parameters
        ----------
        on_serving : callable
            Gets the TCP port as soon as the port answers.
        on_proof : callable
            Gets the state in words whenever the port has answered with a heartbeat that moves.
        refuses : bool
            Whether a fault of the measuring process at start is the end, as it should be for somebody who is looking;
            else the port is served at once, and says what is wrong.

        Raises
        ------
        StartRefusedError
            The measuring process cannot use its settings at start, or the port cannot be had.
        """
        self._refuses = refuses
        self._kept.load()
        self._apply_written()
        parts = [self._keeper.keep(), self._serve(), self._kept.keep(), self._prove(on_serving, on_proof)]
        if self._ingots:
            parts.append(self._ingots.keep())
        tasks = {asyncio.create_task(part) for part in parts}
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()  # an error of our own ends the appliance; the service manager starts it again
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self._server.stop()
            await self._kept.save()

    async def reload(self, load: Callable[[], Settings]) -> None:
        """Take new settings: the measuring process starts again with its own; others count after a restart.

        Parameters
        ----------
        load : callable
            Gives the settings, or raises `SettingsError`: then those that are in force stay.
        """
        try:
            settings = await asyncio.to_thread(load)
        except SettingsError as error:
            self._faults.report("settings_unusable", active=True, detail=str(error))
            return
        self._faults.report("settings_unusable", active=False)
        logger.info("settings are loaded again")
        ingot = settings.ingot if self._ingots and is_on(settings.ingot) else self._settings.ingot
        taken = {"sizing": settings.sizing, "ingot": ingot}
        before, self._settings = self._settings, self._settings.model_copy(update=taken)
        self._faults.report("restart_needed", active=settings != self._settings)
        if settings.sizing != before.sizing:
            self._publication.stale_after_ms = settings.sizing.stale_after_ms
            self._keeper.renew(settings.sizing.model_dump_json())
        if self._ingots and self._settings.ingot != before.ingot:
            self._ingots.renew(settings.ingot)

    async def _serve(self) -> None:
        while self._refuses and self._silent and not (self._refusal or self._stopping):
            await self._news.wait()  # the first message of a station tells whether its settings can be used
            self._news.clear()
        if self._stopping:
            return
        if self._refusal:
            raise StartRefusedError(self._refusal)
        await self._start_server()
        self._serving.set()
        while not self._stopping:
            self._news.clear()
            self._publish()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(SWAP_PERIOD_S):
                    await self._news.wait()

    async def _start_server(self) -> None:
        self._publish()
        self._server.restore(self._kept.written)
        try:
            await self._server.start()
        except OSError as error:
            place, why = f"{self._settings.plc.host}:{self._settings.plc.port}", os.strerror(error.errno or 0)
            raise StartRefusedError(f"cannot serve on {place}: {why}; stop what uses it or set plc.port") from error

    async def _prove(self, on_serving: Callable[[int], None], on_proof: Callable[[str], None]) -> None:
        """Ask the own port again and again; who watches the gauge hears only of answers that move on."""
        await self._serving.wait()
        check = SelfCheck(self._settings.plc.host, self._server.port)
        before: int | None = None
        try:
            while True:
                heartbeat = await check.heartbeat()
                if before is None and heartbeat is not None:
                    on_serving(self._server.port)
                if heartbeat not in {None, before}:
                    on_proof(self._status())
                    before = heartbeat
                await asyncio.sleep(PROOF_PERIOD_S)
        finally:
            check.close()

    def _status(self) -> str:
        if faults := sorted(self._faults.active):
            return f"{'measuring' if self._measuring else 'no value'}; faults: {', '.join(faults)}"
        return "measuring" if self._measuring else "the measuring process is starting"

    def _hear(self, message: Message) -> None:
        if isinstance(message, ReadingMessage):
            self._hear_reading(message)
        elif isinstance(message, StateMessage) and message.state == "faulty":
            self._hear_fault(message)
        elif isinstance(message, StateMessage) and message.state == "warming":
            self._worked_s = time.monotonic()
            return
        self._tell(SIZING)

    def _hear_reading(self, reading: ReadingMessage) -> None:
        self._publication.take(reading)
        self._measuring = True
        self._simulated = reading.simulated
        self._faults.report_station(SIZING, reading.faults)
        now_s = self._worked_s = time.monotonic()
        standing = self._publication.standing(now_s)
        if standing is not None:
            self._bars.take(standing)
            for fault, active in self._lasting.take(standing).items():
                self._faults.report(fault, active=active, station=SIZING)
        self._ring.add(self._measurements(now_s))

    def _hear_fault(self, message: StateMessage) -> None:
        self._stop_measuring(NO_PAIR)
        self._worked_s = time.monotonic()
        if not self._refuse(message.detail):
            self._faults.report_station(SIZING, {message.fault: message.detail})

    def _refuse(self, detail: str) -> bool:
        """Whether a fault is the end: then it is the one sentence that somebody who has just started it reads."""
        if self._refuses and not self._serving.is_set():
            self._refusal = detail
            return True
        return False

    def _tell(self, station: str) -> None:
        """Have published what a station has said."""
        self._silent.discard(station)
        self._news.set()

    def _hear_health(self, health: Health) -> None:
        if health.ended:
            self._stop_measuring(STARTING)
            self._worked_s = time.monotonic()
            self._faults.report_station(SIZING, {})
        for state in ("restarting", "failing"):
            name, active = f"station_{state}", health.state == state
            self._faults.report(name, active=active, detail=health.detail, station=SIZING)
        self._tell(SIZING)

    def _stop_measuring(self, reason: int) -> None:
        self._publication.withdraw(reason)
        self._bars.end()
        self._measuring = False

    def _report_disk(self, fault: str, detail: str) -> None:
        self._faults.report(fault, active=bool(detail), detail=detail)

    def _hear_plc(self, changed: Mapping[str, int | bool]) -> None:
        self._kept.take(changed)
        if "plc_heartbeat" in changed:
            self._plc_beat_s = time.monotonic()
        if changed.get("acknowledge"):
            self._alarms.acknowledge()
            self._faults.acknowledge()
        if set(changed) != {"plc_heartbeat"}:
            self._apply_written()
            self._news.set()

    def _apply_written(self) -> None:
        self._advisor.points = SetPoints.of(self._kept.written)
        self._publication.held = bool(self._kept.written.get("hold"))
        if self._ingots:
            self._ingots.publication.held = self._publication.held
        self._faults.product = self._kept.written.get("product_id", 0)

    def _publish(self) -> None:
        now_s = time.monotonic()
        stale = self._publication.stale(now_s)
        self._faults.report("reading_stale", active=stale, station=SIZING)
        self._faults.report("not_measuring", active=self._is_idle(now_s), station=SIZING)
        self._faults.report("clock_stepped", active=self._clock.was_set(now_s))
        if self._publication.held:
            self._bars.end()
        values = self._measurements(now_s) | self._bars.values() | self._ring.values()
        if self._ingots:
            values |= self._ingots.values(now_s)
        causes = self._faults.active | self._conditions(values, now_s)
        self._alarms.update(causes, now_s, suppressed=self._publication.held)
        values |= self._health(now_s, running=self._measuring and not stale)
        self._server.publish(encode(values, word_order=self._settings.plc.word_order))

    def _is_idle(self, now_s: float) -> bool:
        """Whether the process runs and says nothing that explains why there is no reading."""
        explained = self._faults.active_at(SIZING) - {"not_measuring"}
        return not explained and now_s - self._worked_s > self._settings.sizing.liveness.idle_after_s

    def _measurements(self, now_s: float) -> dict[str, Value]:
        return self._publication.values(now_s) | self._advisor.values(self._publication.standing(now_s), now_s)

    def _conditions(self, values: Mapping[str, Value], now_s: float) -> set[str]:
        """Causes of alarms that are no faults of the gauge."""
        silent_after_s = self._settings.plc.silent_after_s
        there = {
            "wrong_orientation": bool(self._ingots and self._ingots.publication.wrong_orientation(now_s)),
            "out_of_tolerance": values.get("decision") == Decision.OUT,
            "low_trust": self._advisor.low_trust(values),
            "plc_silent": self._plc_beat_s is not None and now_s - self._plc_beat_s > silent_after_s,
        }
        return {condition for condition, is_there in there.items() if is_there}

    def _health(self, now_s: float, *, running: bool) -> dict[str, Value]:
        simulated = self._simulated or bool(self._ingots and self._ingots.publication.simulated)
        check = simulated or self._publication.held or not running
        return {
            "heartbeat": int((now_s - self._started_s) / HEARTBEAT_PERIOD_S),
            "device_state": max(self._faults.state, DeviceState.FUNCTION_CHECK if check else DeviceState.GOOD),
            "alarm_word": self._alarms.word,
            "fault_word": self._faults.word,
            "running": running,
            "simulated": simulated,
        }
