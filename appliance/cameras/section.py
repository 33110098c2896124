"""What every kind of camera must give: its source, itself in words, and what it knows of the line by itself.

A kind is a folder with its settings and its source, and a row in `appliance.cameras.kinds`. The settings load the
source only when it is asked for: the supervisor reads settings and must load no image library.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from appliance.settings.section import Section

if TYPE_CHECKING:
    from appliance.cameras.source import PairSource, PictureSource
    from vision.calibration.rig import Rig
    from vision.ingot.orientation_reader import IngotView
    from vision.sent_picture import SentPicture


class EmptyLine(NamedTuple):
    """Pictures of the line without a bar.

    Attributes
    ----------
    pictures : list of SentPicture
    name : str
        Where they come from, for sentences.
    content : bytes
        Of the file that holds the only picture; empty where the camera has its own pictures of the line.
    """

    pictures: "list[SentPicture]"
    name: str
    content: bytes = b""


class PairCamera(Section, ABC):
    """Settings of a kind of camera that gives image pairs."""

    @property
    @abstractmethod
    def in_words(self) -> str:
        """The camera in the sentence of `hotgauge run`, with its article."""

    @abstractmethod
    def make_source(self, in_step_us: float, /) -> "PairSource":
        """The source of image pairs, not opened yet.

        Parameters
        ----------
        in_step_us : float
            Longest time between the exposures of one pair, µs.

        Raises
        ------
        CameraError
            A library that this kind needs is not installed.
        """

    def own_rig(self) -> "Callable[[], Rig] | None":
        """What calibrates the cameras without a rig file; None where only a rig file can say."""
        return None


class PictureCamera(Section, ABC):
    """Settings of a kind of camera that gives single pictures."""

    is_on: ClassVar[bool] = True

    @property
    @abstractmethod
    def in_words(self) -> str:
        """The camera in the sentence of `hotgauge run`, with its article."""

    @abstractmethod
    def make_source(self) -> "PictureSource":
        """The source of pictures, not opened yet; raises `CameraError` when a library that it needs is missing."""

    def own_empty_line(self) -> EmptyLine | None:
        """Pictures of the empty line that the camera has by itself; None where only a file can show it.

        Raises
        ------
        CameraError
            The pictures cannot be read.
        """
        return None

    def own_ingot_view(self) -> "Callable[[], IngotView] | None":
        """What draws references and regions of an ingot line; None where only a folder of references has them."""
        return None
