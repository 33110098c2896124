"""Settings of the sizing station, by the method that measures."""

from typing import Annotated, cast

from pydantic import BeforeValidator, Field

from appliance.sizing.conveyor.settings import ConveyorSettings
from appliance.sizing.stereo.settings import SizingSettings


def _tangent_unless_given(values: object) -> object:
    return {"method": "tangent"} | cast("dict[str, object]", values) if isinstance(values, dict) else values


Sizing = Annotated[
    Annotated[SizingSettings | ConveyorSettings, Field(discriminator="method")], BeforeValidator(_tangent_unless_given)
]
