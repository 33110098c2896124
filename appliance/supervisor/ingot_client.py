"""The supervisor's side of the ingot station: its publication and its faults."""

from collections.abc import Callable

from appliance.diagnostics.faults import Faults
from appliance.history.recorder import Recorder
from appliance.ingot.message import MESSAGES, IngotMessage
from appliance.ingot.published import IngotPublication
from appliance.ingot.settings import IngotSettings
from appliance.supervisor.start_gate import StartGate
from appliance.supervisor.station_client import StationClient
from plc.rows import Value
from vision.reasons import IngotReason

MODULE = "appliance.ingot.station"
INGOT = "ingot"


def is_on(settings: IngotSettings) -> bool:
    """Whether there is an ingot camera."""
    return settings.camera.is_on


class IngotClient(StationClient[IngotMessage]):
    """The ingot station as the supervisor sees it.

    Parameters
    ----------
    settings : IngotSettings
    faults : Faults
    gate : StartGate
    recorder : Recorder
        Keeps what is decided of ingots.
    on_news : callable
        Called when the registers may have changed.

    Attributes
    ----------
    publication : IngotPublication
    """

    def __init__(
        self,
        settings: IngotSettings,
        *,
        faults: Faults,
        gate: StartGate,
        recorder: Recorder,
        on_news: Callable[[], None],
    ) -> None:
        super().__init__(INGOT, MODULE, settings.model_dump_json(), MESSAGES, faults=faults, gate=gate, on_news=on_news)
        self.publication = IngotPublication(settings.stale_after_ms)
        self._recorder = recorder

    def renew(self, settings: IngotSettings) -> None:
        """Restart the process with new settings."""
        self.publication.stale_after_ms = settings.stale_after_ms
        self._process.renew(settings.model_dump_json())

    def update(self, now_s: float, *, held: bool) -> None:
        """Decide what may be served at `now_s`.

        Parameters
        ----------
        now_s : float
            Monotonic time.
        held : bool
            The PLC holds the gauge: nothing is served.
        """
        self.publication.update(now_s, held=held)
        self._faults.report("reading_stale", active=self.publication.stale, station=INGOT)

    def values(self) -> dict[str, Value]:
        """Values of the registers at the last `update`, by name."""
        return self.publication.values()

    def _add(self, message: IngotMessage) -> None:
        if not self._is_usable(message.exposed_monotonic_s):
            return
        for number, verdict in self.publication.add(message).items():
            self._recorder.add_verdict(verdict, number, simulated=message.simulated)
        self._faults.report_station(INGOT, message.faults)
        self._report_kept(message.not_kept)

    def _withdraw(self, *, restarted: bool) -> None:
        self.publication.withdraw(IngotReason.STARTING if restarted else IngotReason.NO_PICTURE, restarted=restarted)
