"""A supervisor in a thread, with a measuring process that does what it is told, and a PLC's connection to it."""

import asyncio
import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from modbus_wire import Wire
from station_path import STATION_PATH

from appliance.history.settings import HistorySettings
from appliance.sizing.stereo.settings import SizingSettings
from appliance.supervisor import sizing_client
from appliance.supervisor.settings import PlcSettings, Settings
from appliance.supervisor.start_gate import StartRefusedError
from appliance.supervisor.supervisor import Supervisor


class Rehearsal:
    """A supervisor in a thread, its fake station's script, and a PLC's connection."""

    def __init__(self, script: Path, sizing: SizingSettings) -> None:
        self._script = script
        self._sizing = sizing
        self.refused: StartRefusedError | None = None
        self.wall = time.time
        self.on_proof: Callable[[str], None] = lambda _: None
        self.keep_in(None)

    def keep_in(self, folder: Path | None, history: Path | None = None) -> None:
        """Make a supervisor that keeps what the PLC writes in this folder, and a history in another."""
        self._serving = threading.Event()
        self._port = 0
        plc = PlcSettings(writes="all", silent_after_s=1).model_copy(update={"port": 0, "state_directory": folder})
        sections = {"plc": plc, "sizing": self._sizing, "history": HistorySettings(directory=history)}
        self.settings = Settings().model_copy(update=sections)
        self.supervisor = Supervisor(self.settings, wall=lambda: self.wall())  # noqa: PLW0108  a test changes it later
        self._thread = threading.Thread(target=self._run)

    def tell(self, mode: str) -> None:
        new = self._script.with_suffix(".new")
        new.write_text(mode, encoding="utf-8")
        new.replace(self._script)

    def start(self) -> None:
        self._thread.start()

    def connect(self, within_s: float = 10) -> Wire:
        assert self._serving.wait(within_s)
        return Wire(self._port)

    def reload(self, load: Callable[[], Settings]) -> None:
        asyncio.run_coroutine_threadsafe(self.supervisor.reload(load), self._loop).result(10)

    def finish(self) -> None:
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self.supervisor.stop)
        self.wait_for_end()

    def wait_for_end(self) -> None:
        self._thread.join(10)
        assert not self._thread.is_alive()

    def _run(self) -> None:
        try:
            asyncio.run(self._supervise())
        except StartRefusedError as error:
            self.refused = error

    async def _supervise(self) -> None:
        self._loop = asyncio.get_running_loop()
        await self.supervisor.run(self._on_serving, self.on_proof)

    def _on_serving(self, port: int) -> None:
        self._port = port
        self._serving.set()


@contextlib.contextmanager
def rehearsing(
    station: str, folder: Path, monkeypatch: pytest.MonkeyPatch, sizing: SizingSettings | None = None
) -> Iterator[Rehearsal]:
    """A supervisor with a station of the tests, which does what it is told."""
    script = folder / "script"
    monkeypatch.setenv("FAKE_STATION", str(script))
    monkeypatch.setenv("PYTHONPATH", STATION_PATH)
    monkeypatch.setattr(sizing_client, "MODULE", station)
    rehearsal = Rehearsal(script, sizing or SizingSettings())
    rehearsal.tell("measure")
    yield rehearsal
    rehearsal.finish()
