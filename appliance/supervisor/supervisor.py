"""Publishes registers to the PLC every 50 ms, restarts measuring processes, collects faults and alarms.

Everything runs in one asyncio loop that never waits for a station or for the disk: a measuring process that crashes,
hangs or floods the link, or a full disk, changes the values that are published and never stops publishing.
"""

import asyncio
import contextlib
import logging
import math
import time
from collections.abc import Callable, Mapping, Set
from pathlib import Path

from appliance.conformity.plc_inputs import PlcInputs
from appliance.conformity.set_points import SetPoints
from appliance.delivery.settings import DeliverySettings
from appliance.diagnostics.alarms import Alarms
from appliance.diagnostics.faults import Faults
from appliance.errors import HotgaugeError
from appliance.files.atomic_file import file_state
from appliance.history.keeper import HistoryKeeper
from appliance.supervisor.clock_watch import SleepWatch, WallClock
from appliance.supervisor.delivery_client import DeliveryClient
from appliance.supervisor.ingot_client import INGOT, IngotClient, is_on
from appliance.supervisor.plc_server import make_server, report_certificate
from appliance.supervisor.self_check import SelfCheck
from appliance.supervisor.settings import Settings, state_folder
from appliance.supervisor.sizing_client import SIZING, SizingClient
from appliance.supervisor.start_gate import StartGate, StartRefusedError
from plc.codes import DeviceState
from plc.listener import BindError
from plc.process_image import encode
from plc.rows import Value
from plc.security.roles import Client

SWAP_PERIOD_S = 0.05  # half of the longest period allowed, 100 ms, so that a late wake-up stays within it
HEARTBEAT_PERIOD_S = 0.1  # the heartbeat counts at 10 Hz
PROOF_PERIOD_S = 0.5  # chosen: period of the self-check

logger = logging.getLogger("hotgauge.supervisor")


class Supervisor:
    """The appliance without its images.

    Parameters
    ----------
    settings : Settings
    wall : callable
        Wall time, seconds since 1970.
    """

    def __init__(self, settings: Settings, *, wall: Callable[[], float] = time.time) -> None:
        self._settings = settings
        self._server = make_server(settings.plc, self._receive_write)
        self._inputs = PlcInputs(
            state_folder(settings.plc),
            self._report_disk,
            SetPoints.from_settings(settings.sizing.set_points),
            rights=" ".join([settings.plc.writes, *sorted(settings.plc.writers)]),
        )
        self._faults = Faults(lambda: self._inputs.product_id)
        self._alarms = Alarms()
        self._clock = WallClock(wall)
        self._sleep = SleepWatch()
        self._started_s = time.monotonic()
        self._news = asyncio.Event()
        self._serving = asyncio.Event()
        self._one_reload = asyncio.Lock()
        self._stopping = False
        self._refuses = False
        self._kept: Set[str] = frozenset()
        delivery = DeliverySettings(metrics=settings.metrics, mqtt=settings.mqtt)
        self._delivery = DeliveryClient(delivery, self._faults) if delivery.is_on else None
        self._history = HistoryKeeper(
            settings.history,
            self._inputs,
            trust_min=settings.judging.trust_min,
            deliver=self._delivery.put if self._delivery else None,
            wall=wall,
        )
        self._scale_state = file_state(self._scale_file())
        self._gate = StartGate({SIZING, INGOT} if is_on(settings.ingot) else {SIZING})
        self._sizing = SizingClient(
            settings.sizing,
            settings.judging,
            settings.correction,
            inputs=self._inputs,
            faults=self._faults,
            gate=self._gate,
            recorder=self._history.recorder,
            on_news=self._news.set,
        )
        self._ingots = self._make_ingots(settings) if is_on(settings.ingot) else None

    def _make_ingots(self, settings: Settings) -> IngotClient:
        return IngotClient(
            settings.ingot,
            faults=self._faults,
            gate=self._gate,
            recorder=self._history.recorder,
            on_news=self._news.set,
        )

    def _scale_file(self) -> Path | None:
        return self._settings.sizing.scale_file

    def stop(self) -> None:
        """Make `run` return."""
        self._stopping = True
        self._gate.open()
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
            Receives the TCP port once the port answers.
        on_proof : callable
            Receives the state in words each time that the port has answered with a new heartbeat.
        refuses : bool
            True: a fault of a measuring process at start raises StartRefusedError, for a person at a terminal.
            False: the port is served at once and shows the fault, for a service.

        Raises
        ------
        StartRefusedError
            A measuring process cannot use its settings at start, or the port cannot be opened.
        """
        self._refuses = refuses
        if not refuses:
            self._gate.open()
        self._inputs.load()
        parts = [self._sizing.run(), self._serve(), self._inputs.keep(), self._history.keep()]
        parts.append(self._prove(on_serving, on_proof))
        if self._ingots:
            parts.append(self._ingots.run())
        if self._delivery:
            parts.append(self._delivery.run())
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
            await self._inputs.save()
            await self._history.stop()

    def keep_pictures(self, why: str = "request") -> None:
        """Have every station write the last seconds of its pictures, if it keeps any.

        Parameters
        ----------
        why : str
            Name of the cause.
        """
        self._sizing.keep_pictures(why)
        if self._ingots:
            self._ingots.keep_pictures(why)

    async def reload(self, load: Callable[[], Settings]) -> None:
        """Apply new settings: stations whose settings, or rig file, changed restart; others report `restart_needed`.

        Parameters
        ----------
        load : callable
            Returns the settings. If it raises `SettingsError`, the settings in force stay and a fault is reported.
        """
        async with self._one_reload:  # of two, the later one wins
            await self._reload(load)

    async def _reload(self, load: Callable[[], Settings]) -> None:
        try:
            settings = await asyncio.to_thread(load)
        except (HotgaugeError, OSError, ValueError, RecursionError) as error:
            self._faults.report("settings_unusable", active=True, detail=str(error) or type(error).__name__)
            return
        self._faults.report("settings_unusable", active=False)
        logger.info("settings are loaded again")
        ingot = settings.ingot if self._ingots and is_on(settings.ingot) else self._settings.ingot
        in_force = {"sizing": settings.sizing, "ingot": ingot}
        before, self._settings = self._settings, self._settings.model_copy(update=in_force)
        self._faults.report("restart_needed", active=settings != self._settings)
        self._inputs.settings = SetPoints.from_settings(settings.sizing.set_points)
        scale_before, self._scale_state = self._scale_state, file_state(self._scale_file())
        same = settings.sizing.model_copy(update={"set_points": before.sizing.set_points}) == before.sizing
        if not same or self._scale_state != scale_before:
            self._sizing.renew(settings.sizing)
        if self._ingots and self._settings.ingot != before.ingot:
            self._ingots.renew(settings.ingot)

    async def _serve(self) -> None:
        await self._gate.wait()
        if self._stopping:
            return
        self._publish()
        self._server.restore(self._inputs.written)
        await self._start_server()
        self._serving.set()
        while not self._stopping:
            self._news.clear()
            self._publish()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(SWAP_PERIOD_S):
                    await self._news.wait()

    async def _start_server(self) -> None:
        try:
            await self._server.start()
        except BindError as error:
            raise StartRefusedError(error.sentence) from error
        if self._refuses and self._server.secure and self._server.secure.trouble:
            raise StartRefusedError(self._server.secure.trouble)

    async def _prove(self, on_serving: Callable[[int], None], on_proof: Callable[[str], None]) -> None:
        """Read our own server every PROOF_PERIOD_S and report each new heartbeat to the service manager."""
        await self._serving.wait()
        check = SelfCheck(self._server.connect)
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
            return f"{'measuring' if self._sizing.measuring else 'no value'}; faults: {', '.join(faults)}"
        return "measuring" if self._sizing.measuring else "the measuring process is starting"

    def _report_disk(self, fault: str, detail: str) -> None:
        self._faults.report(fault, active=bool(detail), detail=detail)

    def _receive_write(self, changed: Mapping[str, int | bool], client: Client) -> None:
        self._inputs.add(changed)
        self._shelve(changed)
        self._history.recorder.add_writes(changed, client)
        if changed.get("keep_pictures"):
            self.keep_pictures()
        if changed.get("acknowledge"):
            self._alarms.acknowledge()
            self._faults.acknowledge()
        if set(changed) != {"plc_heartbeat"}:
            self._publish()  # at once: function 23 reads in the same request what its writing has changed

    def _shelve(self, changed: Mapping[str, int | bool]) -> None:
        """Shelve alarms whose command has come, and show those again whose command was taken back."""
        until_s = time.monotonic() + 60 * self._settings.plc.shelving_min
        for name, level in changed.items():
            if name.startswith("shelve_"):
                self._alarms.shelve(f"alarm_{name.removeprefix('shelve_')}", until_s if level else -math.inf)

    def _publish(self) -> None:
        now_s = time.monotonic()
        self._update(now_s)
        values = self._sizing.values()
        if self._ingots:
            values |= self._ingots.values()
        values |= self._health(now_s)
        self._server.publish(encode(values, word_order=self._settings.plc.word_order))
        if self._delivery:
            self._delivery.put_figures(values, self._alarms)

    def _update(self, now_s: float) -> None:
        """Update stations, faults and alarms to `now_s`."""
        if self._sleep.has_slept():
            for station in filter(None, (self._sizing, self._ingots)):
                station.distrust_until(now_s)
        self._sizing.update(now_s)
        if self._ingots:
            self._ingots.update(now_s, held=self._inputs.held)
        self._faults.report("clock_stepped", active=self._clock.was_set(now_s))
        report_certificate(self._server, self._faults)
        self._history.update(self._faults, self._alarms)
        conditions = {name for name, there in self._conditions(now_s).items() if there}
        self._alarms.update(self._faults.active | conditions, now_s, suppressed=self._inputs.held)
        self._keep_new(self._alarms.active | conditions & {"out_of_tolerance"})

    def _keep_new(self, causes: Set[str]) -> None:
        """Have pictures kept of each alarm that comes, and of a decision "out" before its alarm."""
        for why in sorted(causes - self._kept):
            self.keep_pictures(why)
        self._kept = causes

    def _conditions(self, now_s: float) -> dict[str, bool]:
        """Alarm causes that are no faults of the gauge, by name."""
        beat_s = self._inputs.heartbeat_s
        return self._sizing.conditions() | {
            "wrong_orientation": bool(self._ingots and self._ingots.publication.wrong_orientation),
            "plc_silent": beat_s is not None and now_s - beat_s > self._settings.plc.silent_after_s,
        }

    def _health(self, now_s: float) -> dict[str, Value]:
        simulated = self._sizing.simulated or bool(self._ingots and self._ingots.publication.simulated)
        check = simulated or self._inputs.held or not self._sizing.running
        return {
            "heartbeat": int((now_s - self._started_s) / HEARTBEAT_PERIOD_S),
            "device_state": max(self._faults.state, DeviceState.FUNCTION_CHECK if check else DeviceState.GOOD),
            "alarm_word": self._alarms.word,
            "alarms_shelved": self._alarms.shelved_word,
            "fault_word": self._faults.word,
            "clients_refused": self._server.refused,
            "running": self._sizing.running,
            "simulated": simulated,
        }
