"""The supervisor's side of a station: its process, its faults, and its part in allowing the start."""

import abc
import math
import time
from collections.abc import Callable
from typing import Generic

from appliance.diagnostics.faults import Faults
from appliance.processes.message import KeepPictures, Messages, MessageT, StateMessage
from appliance.processes.monitored_process import Health, MonitoredProcess
from appliance.supervisor.start_gate import StartGate

FUTURE_MOST_S = 1.0  # chosen: both clocks are this computer's own; liveness already refuses 0.05 s
PAST_MOST_S = 3600.0  # chosen: a process that was stopped for longer than this is started anew


def refuse_impossible(exposed_s: float) -> None:
    """Raise `ValueError`, which ends the process, for an exposure in the future or from long ago, monotonic time."""
    age_s = time.monotonic() - exposed_s
    if not -FUTURE_MOST_S <= age_s <= PAST_MOST_S:
        raise ValueError(f"an exposure {age_s:g} s ago")


class StationClient(abc.ABC, Generic[MessageT]):
    """One station as the supervisor sees it.

    Parameters
    ----------
    name : str
        Name of the station in faults and logs.
    module : str
        Python module of its process.
    settings_json : str
        Settings for the process.
    messages : TypeAdapter
        Reads the messages of the process.
    faults : Faults
    gate : StartGate
    on_news : callable
        Called when the registers may have changed.
    """

    def __init__(
        self,
        name: str,
        module: str,
        settings_json: str,
        messages: Messages[MessageT],
        *,
        faults: Faults,
        gate: StartGate,
        on_news: Callable[[], None],
    ) -> None:
        self.name = name
        self._process = MonitoredProcess(module, settings_json, messages, self._receive, self._receive_health)
        self._faults = faults
        self._gate = gate
        self._on_news = on_news
        self._trusted_from_s = -math.inf

    async def run(self) -> None:
        """Keep the process running until cancelled."""
        await self._process.run()

    def keep_pictures(self, why: str) -> None:
        """Have the station write the last seconds of pictures, if it keeps any.

        Parameters
        ----------
        why : str
            Name of the cause.
        """
        self._process.send(KeepPictures(why=why).model_dump_json().encode())

    def _report_kept(self, trouble: str) -> None:
        """Report why pictures of the black box could not be written; empty if they could."""
        self._faults.report(
            "history_not_written", active=bool(trouble), detail=trouble, station=f"{self.name} black box"
        )

    def distrust_until(self, now_s: float) -> None:
        """Withdraw what was exposed before `now_s`, monotonic: the computer slept, and its age is not known."""
        self._trusted_from_s = now_s
        self._withdraw(restarted=False)

    def _is_usable(self, exposed_s: float) -> bool:
        """Whether an exposure counts; raises `ValueError`, which ends the process, for one that cannot be."""
        refuse_impossible(exposed_s)
        return exposed_s >= self._trusted_from_s

    @abc.abstractmethod
    def _add(self, message: MessageT) -> None:
        """Publish a measurement of the station."""

    @abc.abstractmethod
    def _withdraw(self, *, restarted: bool) -> None:
        """Withdraw the station's measurement from the registers.

        Parameters
        ----------
        restarted : bool
            Whether the reason is that its process has ended.
        """

    def _warming(self) -> None:
        """Note that the process still compiles and cannot measure yet."""

    def _receive(self, message: StateMessage | MessageT) -> None:
        if not isinstance(message, StateMessage):
            self._add(message)
        elif message.state == "faulty":
            self._receive_fault(message)
        elif message.state == "warming":
            self._warming()
            return
        self._announce()

    def _receive_fault(self, message: StateMessage) -> None:
        self._withdraw(restarted=False)
        if not self._gate.refuse(message.detail):
            self._faults.report_station(self.name, {message.fault: message.detail})

    def _receive_health(self, health: Health) -> None:
        if health.ended:
            self._withdraw(restarted=True)
            self._faults.report_station(self.name, {})
        for state in ("restarting", "failing"):
            name, active = f"station_{state}", health.state == state
            self._faults.report(name, active=active, detail=health.detail, station=self.name)
        self._announce()

    def _announce(self) -> None:
        self._gate.count_station(self.name)
        self._on_news()
