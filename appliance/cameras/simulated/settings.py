"""Settings of the simulated mill, ingot line and thermal line in place of cameras."""

from typing import Literal

from pydantic import Field

from appliance.settings.section import Section, unit


class MillCamera(Section):
    """The simulated mill as camera."""

    kind: Literal["mill"] = Field(default="mill", description="A simulated mill, for trying and testing")
    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="Seed of bars and noise")
    rate_hz: float = Field(
        default=10.0, gt=0, le=60, description="Image pairs per second", json_schema_extra=unit("1/s")
    )
    prepared_frames: int = Field(
        default=0,
        ge=0,
        le=600,
        description="Frames drawn before the start and then played as a loop, at any rate; 0 draws as it goes",
    )


class MillPictures(Section):
    """The simulated ingot line as camera."""

    kind: Literal["mill"] = Field(description="A simulated ingot line, for trying and testing")
    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="Seed of line, ingots and noise")
    rate_hz: float = Field(default=5.0, gt=0, le=60, description="Pictures per second", json_schema_extra=unit("1/s"))


class MillThermal(Section):
    """The simulated thermal line as camera."""

    kind: Literal["mill"] = Field(
        default="mill", description="A simulated thermal line, barriers 600 mm apart and 100 mm high, for trying"
    )
    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="Seed of bars and noise")
    rate_hz: float = Field(default=10.0, gt=0, le=60, description="Pictures per second", json_schema_extra=unit("1/s"))
