"""The simulated thermal line as a camera."""

from typing import Self

from appliance.cameras.pacing import Pacer
from appliance.cameras.simulated.pairs import drawn_frame
from appliance.cameras.source import Frame
from appliance.simulation.thermal_line import ThermalLine, ThermalSequence, thermal_camera
from vision.sent_picture import SentPicture

SPACING_MM, HEIGHT_MM = 600.0, 100.0  # of the barriers; bars of up to 300 mm pass between them
EMPTY_PICTURES = 5  # drawn of the line before the first bar


class ThermalMillSource:
    """Pictures of the simulated thermal line in real time; see `PictureSource`. They are drawn as they are asked for.

    Parameters
    ----------
    seed : int
        Bars and noise; the same seed gives the same pictures, frame by frame.
    rate_hz : float
        Exposures per second; 0 delivers every frame as fast as it is asked for. Frames that nobody took in time are
        left out and counted as dropped.
    """

    simulated = True

    def __init__(self, seed: int, rate_hz: float) -> None:
        self._rate_hz = rate_hz
        self._sequence = ThermalSequence(
            ThermalLine(thermal_camera(), spacing_mm=SPACING_MM, height_mm=HEIGHT_MM, seed=seed)
        )

    def __enter__(self) -> Self:
        """Start the clock."""
        self._pacer = Pacer(self._rate_hz)
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is held open."""

    def empty(self) -> list[SentPicture]:
        """Pictures of the line before the first bar."""
        return [SentPicture.of(self._sequence.empty(number)) for number in range(EMPTY_PICTURES)]

    def next(self, timeout_s: float) -> Frame | None:
        """Newest picture that is due, with its truth; None when none is due in time."""
        return drawn_frame(self._pacer, timeout_s, self._sequence.picture)
