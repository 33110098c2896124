"""Settings of the simulated mill, ingot line and thermal line in place of cameras."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from appliance.cameras.section import EmptyLine, PairCamera, PictureCamera
from appliance.settings.section import unit

if TYPE_CHECKING:
    from appliance.cameras.source import PairSource, PictureSource
    from vision.calibration.rig import Rig
    from vision.ingot.orientation_reader import IngotView


class MillCamera(PairCamera):
    """The simulated mill as camera."""

    kind: Literal["mill"] = Field(default="mill", description="A simulated mill, for trying and testing")
    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="Seed of bars and noise")
    rate_hz: float = Field(
        default=10.0, gt=0, le=60, description="Image pairs per second", json_schema_extra=unit("1/s")
    )
    shows: Literal["bars", "boards", "low", "high"] = Field(
        default="bars",
        description="Bars that pass, or a checkerboard for `hotgauge capture`: in poses, flat below, flat above",
    )
    prepared_frames: int = Field(
        default=0,
        ge=0,
        le=600,
        description="Frames drawn before the start and then played as a loop, at any rate; 0 draws as it goes",
    )

    @property
    def in_words(self) -> str:
        """The simulated mill."""
        return "the simulated mill"

    def make_source(self, _in_step_us: float, /) -> "PairSource":
        """Drawn image pairs; see `PairCamera.make_source`."""
        from appliance.cameras.simulated.boards import MillBoardSource
        from appliance.cameras.simulated.pairs import MillSource

        if self.shows != "bars":
            return MillBoardSource(self.seed, self.rate_hz, self.shows)
        return MillSource(self.seed, self.rate_hz, self.prepared_frames)

    def own_rig(self) -> "Callable[[], Rig]":
        """The calibration from this mill's boards; it takes about a second."""
        from appliance.cameras.simulated.pairs import MillSource
        from appliance.cameras.simulated.rig import mill_rig

        return partial(mill_rig, MillSource(self.seed, self.rate_hz))


class MillPictures(PictureCamera):
    """The simulated ingot line as camera."""

    kind: Literal["mill"] = Field(description="A simulated ingot line, for trying and testing")
    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="Seed of line, ingots and noise")
    rate_hz: float = Field(default=5.0, gt=0, le=60, description="Pictures per second", json_schema_extra=unit("1/s"))

    @property
    def in_words(self) -> str:
        """The simulated ingot line."""
        return "the simulated ingot line"

    def make_source(self) -> "PictureSource":
        """Drawn pictures of the ingot line; see `PictureCamera.make_source`."""
        from appliance.cameras.simulated.ingots import IngotMillSource

        return IngotMillSource(self.seed, self.rate_hz)

    def own_ingot_view(self) -> "Callable[[], IngotView]":
        """References and regions of the line of this seed; drawing them takes about half a second."""
        from appliance.cameras.simulated.ingots import mill_view

        return partial(mill_view, self.seed)


class MillThermal(PictureCamera):
    """The simulated thermal line as camera."""

    kind: Literal["mill"] = Field(
        default="mill", description="A simulated thermal line, barriers 600 mm apart and 100 mm high, for trying"
    )
    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="Seed of bars and noise")
    rate_hz: float = Field(default=10.0, gt=0, le=60, description="Pictures per second", json_schema_extra=unit("1/s"))

    @property
    def in_words(self) -> str:
        """The simulated thermal line."""
        return "the simulated thermal line"

    def make_source(self) -> "PictureSource":
        """Drawn pictures of the thermal line; see `PictureCamera.make_source`."""
        from appliance.cameras.simulated.thermal import ThermalMillSource

        return ThermalMillSource(self.seed, self.rate_hz)

    def own_empty_line(self) -> EmptyLine:
        """Pictures of the line of this seed before the first bar."""
        from appliance.cameras.simulated.thermal import ThermalMillSource

        return EmptyLine(ThermalMillSource(self.seed, self.rate_hz).empty(), "the simulated line")
