"""Keeps the PLC's port closed until every station has reported that its settings can be used."""

import asyncio
from collections.abc import Iterable

from appliance.errors import HotgaugeError


class StartRefusedError(HotgaugeError):
    """The appliance cannot start with these settings; the message says what, where and what to do."""


class StartGate:
    """The start of the appliance: a station's first fault refuses it; it is allowed when all stations have reported.

    Parameters
    ----------
    stations : iterable of str
        Names of the stations that must report first.
    """

    def __init__(self, stations: Iterable[str]) -> None:
        self._silent = set(stations)
        self._refusal = ""
        self._open = False
        self._decided = asyncio.Event()

    def open(self) -> None:
        """Allow the start now; later faults no longer refuse it."""
        self._open = True
        self._decided.set()

    def count_station(self, station: str) -> None:
        """Count a station that has reported; after the last one the start is allowed."""
        self._silent.discard(station)
        if not self._silent:
            self._decided.set()

    def refuse(self, detail: str) -> bool:
        """Refuse the start, unless it was allowed before; return whether it is refused.

        `wait` then raises with the sentence `detail`, which the command prints.
        """
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
