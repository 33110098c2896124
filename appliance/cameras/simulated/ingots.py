"""The simulated ingot line as a source of pictures."""

from typing import Self

from appliance.cameras.pacing import Pacer
from appliance.cameras.simulated.pairs import Picture, drawn_frame
from appliance.cameras.source import Frame
from appliance.simulation.ingots.conditions import ingot_line
from appliance.simulation.ingots.faces import Label
from appliance.simulation.ingots.sequence import IngotSequence


class IngotMillSource:
    """Pictures of the simulated ingot line in real time; see `PictureSource`. They are drawn as they are asked for.

    Parameters
    ----------
    seed : int
        Line, ingots and noise; the same seed gives the same pictures, frame by frame.
    rate_hz : float
        Exposures per second; 0 delivers every frame as fast as it is asked for. Frames that nobody took in time are
        left out and counted as dropped.
    condition : str
        Of `INGOT_CONDITIONS`; raises `ValueError` when it is not in the table.

    Attributes
    ----------
    line : IngotLine
        What is known of the line before: `roi_crop()`, `roi_centroid()`, `radius_px()`.
    """

    simulated = True

    def __init__(self, seed: int, rate_hz: float, condition: str = "mixed") -> None:
        self._rate_hz = rate_hz
        self.line = ingot_line(seed, condition)

    def __enter__(self) -> Self:
        """Draw what stands still, then start the clock."""
        self._sequence = IngotSequence(self.line)
        self._pacer = Pacer(self._rate_hz)
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is held open."""

    def references(self) -> dict[Label, Picture]:
        """Bottom squares of a top and a bottom that come in no picture; only while the source is open."""
        return self._sequence.references

    def next(self, timeout_s: float) -> Frame | None:
        """Newest picture that is due, with its truth; None when none is due in time."""
        return drawn_frame(self._pacer, timeout_s, self._draw)

    def _draw(self, number: int) -> tuple[Picture, dict[str, object]]:
        picture, truth = self._sequence.picture(number)
        return picture, truth._asdict()
