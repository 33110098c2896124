"""The supervisor's side of the sizing station: publication, conformity, bar statistics and faults of its readings."""

import time
from collections.abc import Callable

from appliance.conformity.advisor import Advisor
from appliance.conformity.bar_statistics import BarStatistics
from appliance.conformity.plc_inputs import PlcInputs
from appliance.conformity.settings import CorrectionSettings, JudgingSettings
from appliance.diagnostics.faults import Faults
from appliance.history.recorder import Recorder
from appliance.sizing.conveyor.settings import ConveyorSettings
from appliance.sizing.lasting_reasons import LastingReasons
from appliance.sizing.message import MESSAGES, ReadingMessage
from appliance.sizing.published import Publication
from appliance.sizing.reading_ring import ReadingRing
from appliance.sizing.stereo.settings import SizingSettings
from appliance.supervisor.start_gate import StartGate
from appliance.supervisor.station_client import StationClient
from plc.codes import Decision
from plc.rows import Value
from vision.reasons import Reason

MODULE = "appliance.sizing.station"
SIZING = "sizing"
LASTING_TIME_S = 10.0  # chosen: a reason that stays for so long on bars is a fault of the gauge


class SizingClient(StationClient[ReadingMessage]):
    """The sizing station as the supervisor sees it.

    Parameters
    ----------
    settings : SizingSettings or ConveyorSettings
    judging : JudgingSettings
    correction : CorrectionSettings
    inputs : PlcInputs
        What the PLC has written.
    faults : Faults
    gate : StartGate
    recorder : Recorder
        Keeps readings and bars.
    on_news : callable
        Called when the registers may have changed.

    Attributes
    ----------
    simulated : bool
        Whether the last reading was of a simulated bar or of a recording.
    measuring : bool
        Whether readings come.
    running : bool
        Whether readings come and the newest was not too old at the last `update`.
    """

    def __init__(
        self,
        settings: SizingSettings | ConveyorSettings,
        judging: JudgingSettings,
        correction: CorrectionSettings,
        *,
        inputs: PlcInputs,
        faults: Faults,
        gate: StartGate,
        recorder: Recorder,
        on_news: Callable[[], None],
    ) -> None:
        super().__init__(
            SIZING, MODULE, settings.model_dump_json(), MESSAGES, faults=faults, gate=gate, on_news=on_news
        )
        self.simulated = self.measuring = self.running = False
        self._idle_after_s = settings.liveness.idle_after_s
        self._inputs = inputs
        self._recorder = recorder
        self._scale_file = settings.scale_file
        recorder.set_adjustment(settings.adjustment)
        self._publication = Publication(settings.stale_after_ms)
        self._advisor = Advisor(judging, correction)
        self._ring = ReadingRing()
        self._bars = BarStatistics(judging.bar_gap_ms / 1000)
        self._lasting = LastingReasons(LASTING_TIME_S)
        self._worked_s = time.monotonic()

    def renew(self, settings: SizingSettings | ConveyorSettings) -> None:
        """Restart the process with new settings."""
        self._recorder.set_adjustment(settings.adjustment)
        self._scale_file = settings.scale_file
        self._publication.stale_after_ms = settings.stale_after_ms
        self._idle_after_s = settings.liveness.idle_after_s
        self._process.renew(settings.model_dump_json())

    def update(self, now_s: float) -> None:
        """Decide what may be served at `now_s`, monotonic, judge it, and report faults."""
        self._judge(now_s)
        self.running = self.measuring and not self._publication.stale
        self._faults.report("reading_stale", active=self._publication.stale, station=SIZING)
        self._faults.report("not_measuring", active=self._is_idle(now_s), station=SIZING)
        if self._inputs.held:
            self._bars.end()
        if not self._bars.passing:
            self._recorder.end_bar()

    def values(self) -> dict[str, Value]:
        """Values of the registers at the last `update`, by name."""
        return self._newest_values() | self._bars.values() | self._ring.values()

    def conditions(self) -> dict[str, bool]:
        """Alarm causes that lie in the bar and not in the gauge, by name."""
        return {
            "out_of_tolerance": self._advisor.decision is Decision.OUT,
            "low_trust": self._advisor.low_trust,
        }

    def _judge(self, now_s: float) -> None:
        self._publication.update(now_s, held=self._inputs.held)
        standing = self._publication.standing
        self._advisor.update(None if standing is None else standing.reading, self._inputs.points, now_s)

    def _newest_values(self) -> dict[str, Value]:
        return self._publication.values() | self._advisor.values()

    def _is_idle(self, now_s: float) -> bool:
        """Whether readings are missing for longer than `idle_after_s` without a fault that explains it."""
        explained = self._faults.active_at(SIZING) - {"not_measuring"}
        return not explained and now_s - self._worked_s > self._idle_after_s

    def _warming(self) -> None:
        self._worked_s = time.monotonic()

    def _add(self, message: ReadingMessage) -> None:
        if not self._is_usable(message.exposed_monotonic_s):
            return
        self._publication.add(message)
        self.measuring = True
        self.simulated = message.simulated
        self._faults.report_station(SIZING, message.faults)
        self._report_kept(message.not_kept)
        self._recorder.set_calibration(self._scale_file, message.scale_sha256)
        now_s = self._worked_s = time.monotonic()
        self._judge(now_s)
        if self._publication.standing is not None:
            self._bars.add(message)
            self._lasting.add(message)
            for fault, active in self._lasting.faults().items():
                self._faults.report(fault, active=active, station=SIZING)
        newest = self._newest_values()
        self._ring.add(newest)
        self._recorder.add_reading(message, newest | self._bars.values())

    def _withdraw(self, *, restarted: bool) -> None:
        self._publication.withdraw(Reason.STARTING if restarted else Reason.NO_PAIR)
        self._bars.end()
        self.measuring = False
        self._worked_s = time.monotonic()
