"""The supervisor's side of the ingot station: its process, its faults, its part of the registers."""

from collections.abc import Callable

from appliance.diagnostics.faults import Faults
from appliance.ingot.message import IngotMessage
from appliance.ingot.published import NO_PICTURE, STARTING, IngotPublication
from appliance.ingot.settings import IngotSettings
from appliance.processes.link import Message
from appliance.processes.message import StateMessage
from appliance.processes.monitored_process import Health, Keeper
from plc.rows import Value

MODULE = "appliance.ingot.station"
INGOT = "ingot"


def is_on(settings: IngotSettings) -> bool:
    """Whether there is an ingot camera."""
    return settings.camera.is_on


class IngotSide:
    """The ingot station as the supervisor sees it.

    Parameters
    ----------
    settings : IngotSettings
    faults : Faults
    on_news : callable
        Gets the name of the station whenever there is something to publish.
    refuses : callable
        Gets the sentence of each fault that the station tells; says whether it is the end of the appliance.

    Attributes
    ----------
    publication : IngotPublication
    """

    def __init__(
        self,
        settings: IngotSettings,
        faults: Faults,
        on_news: Callable[[str], None],
        refuses: Callable[[str], bool],
    ) -> None:
        self.publication = IngotPublication(settings.stale_after_ms)
        self._keeper = Keeper(MODULE, settings.model_dump_json(), self._hear, self._hear_health)
        self._faults = faults
        self._on_news = on_news
        self._refuses = refuses

    async def keep(self) -> None:
        """Keep the process running until cancelled."""
        await self._keeper.keep()

    def renew(self, settings: IngotSettings) -> None:
        """End the process and start one with other settings."""
        self.publication.stale_after_ms = settings.stale_after_ms
        self._keeper.renew(settings.model_dump_json())

    def values(self, now_s: float) -> dict[str, Value]:
        """Values of the registers at one moment, by name."""
        self._faults.report("reading_stale", active=self.publication.stale(now_s), station=INGOT)
        return self.publication.values(now_s)

    def _hear(self, message: Message) -> None:
        if isinstance(message, IngotMessage):
            self.publication.take(message)
            self._faults.report_station(INGOT, message.faults)
        elif isinstance(message, StateMessage) and message.state == "faulty":
            self.publication.withdraw(NO_PICTURE, restarted=False)
            if not self._refuses(message.detail):
                self._faults.report_station(INGOT, {message.fault: message.detail})
        self._on_news(INGOT)

    def _hear_health(self, health: Health) -> None:
        if health.ended:
            self.publication.withdraw(STARTING, restarted=True)
            self._faults.report_station(INGOT, {})
        for state in ("restarting", "failing"):
            name, active = f"station_{state}", health.state == state
            self._faults.report(name, active=active, detail=health.detail, station=INGOT)
        self._on_news(INGOT)
