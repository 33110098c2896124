"""Holds the PLC's port back until every station has said that its settings can be used."""

import asyncio
from collections.abc import Iterable

from appliance.errors import HotgaugeError


class StartRefusedError(HotgaugeError):
    """The appliance cannot start with these settings; the message says what, where and what to do."""


class StartGate:
    """The start of the appliance: refused by the first fault of a station, allowed when all stations have spoken.

    Parameters
    ----------
    stations : iterable of str
        Names of the stations that have to speak first.
    """

    def __init__(self, stations: Iterable[str]) -> None:
        self._silent = set(stations)
        self._refusal = ""
        self._open = False
        self._decided = asyncio.Event()

    def open(self) -> None:
        """Allow the start now; from here on no fault refuses it."""
        self._open = True
        self._decided.set()

    def hear(self, station: str) -> None:
        """Count a station that has spoken."""
        self._silent.discard(station)
        if not self._silent:
            self._decided.set()

    def refuse(self, detail: str) -> bool:
        """Whether a fault refuses the start; its sentence is then all that somebody who has just started it reads."""
        if self._open:
            return False
        self._refusal = detail
        self._decided.set()
        return True

    async def wait(self) -> None:
        """Wait until the start is allowed.

        Raises
        ------
        StartRefusedError
            A station cannot use its settings.
        """
        await self._decided.wait()
        if self._refusal:
            raise StartRefusedError(self._refusal)
        self.open()
