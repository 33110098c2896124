"""The simulated ingot line as a source of pictures."""

from typing import Self

from appliance.cameras.pacing import Pacer
from appliance.cameras.simulated.pairs import Picture, drawn_frame
from appliance.cameras.source import Frame
from appliance.simulation.ingots.conditions import ingot_line
from appliance.simulation.ingots.sequence import IngotSequence
from vision.ingot.end_finder import Box
from vision.ingot.orientation_reader import IngotView, References

CONDITION = "mixed"  # of the line that the settings draw: everything that the line can show


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
    """

    simulated = True

    def __init__(self, seed: int, rate_hz: float, condition: str = CONDITION) -> None:
        self._rate_hz = rate_hz
        self._line = ingot_line(seed, condition)

    def __enter__(self) -> Self:
        """Draw what stands still, then start the clock."""
        self._sequence = IngotSequence(self._line)
        self._pacer = Pacer(self._rate_hz)
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is held open."""

    def next(self, timeout_s: float) -> Frame | None:
        """Newest picture that is due, with its truth; None when none is due in time."""
        return drawn_frame(self._pacer, timeout_s, self._draw)

    def _draw(self, number: int) -> tuple[Picture, dict[str, object]]:
        picture, truth = self._sequence.picture(number)
        return picture, truth._asdict()


def mill_view(seed: int) -> IngotView:
    """References and regions of the line that a seed draws, as somebody would have recorded them before."""
    sequence = IngotSequence(ingot_line(seed, CONDITION))
    pictures = sequence.references
    return IngotView(
        References(pictures["top"], pictures["bottom"]), Box(*sequence.roi_crop), Box(*sequence.roi_centroid)
    )
