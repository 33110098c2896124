"""Settings of the laser beside the cameras: where its beam runs in the line, and how its range is read."""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import AfterValidator, Field

from appliance.settings.section import Section, unit

if TYPE_CHECKING:
    from appliance.sizing.range_sensor.sensor import RangeSensor

# The simulated mill's laser hangs over the line's middle and looks down.
MILL_ORIGIN_MM, MILL_DIRECTION, MILL_U_MM = (0.0, 0.0, 2200.0), (0.0, 0.0, -1.0), 0.5


def _a_direction(numbers: list[float]) -> list[float]:
    if not any(numbers):
        raise ValueError("0, 0, 0 is no direction; give x, y and z from the sensor towards the line")
    return numbers


def _a_span(numbers: list[float]) -> list[float]:
    if not 0 <= numbers[0] < numbers[1]:
        raise ValueError("give the least range first, then the greatest")
    return numbers


Span = Annotated[list[float], Field(min_length=2, max_length=2), AfterValidator(_a_span)]
Place = Annotated[list[float], Field(min_length=3, max_length=3)]
Direction = Annotated[Place, AfterValidator(_a_direction)]


class NoRange(Section):
    """No laser."""

    kind: Literal["off"] = Field(default="off", description="Cameras alone")

    def make_sensor(self) -> "RangeSensor":
        """None."""
        from appliance.sizing.range_sensor.sensor import NoRangeSensor

        return NoRangeSensor()


class RangeSettings(Section, ABC):
    """The beam, and how far its spot is known."""

    origin_mm: Place = Field(
        description="Where the range is 0, in the rig's coordinates: x across, y along, z up",
        json_schema_extra=unit("mm"),
    )
    direction: Direction = Field(description="Of the beam: x, y and z from the sensor towards the line, of any length")
    u_mm: float = Field(
        gt=0,
        le=50,
        description="Standard uncertainty (k = 1) of the spot's place: range, beam and hot surface together",
        json_schema_extra=unit("mm"),
    )

    @abstractmethod
    def make_sensor(self) -> "RangeSensor":
        """Make the sensor, not opened yet."""


class MillRange(RangeSettings):
    """The simulated mill's own laser, for trying."""

    kind: Literal["mill"] = Field(description="The simulated mill's laser, over the middle of the line")
    origin_mm: Place = Field(
        default=list(MILL_ORIGIN_MM), description="As for modbus; the mill's laser", json_schema_extra=unit("mm")
    )
    direction: Direction = Field(default=list(MILL_DIRECTION), description="As for modbus; the mill's laser")
    u_mm: float = Field(
        default=MILL_U_MM, gt=0, le=50, description="As for modbus; the mill's laser", json_schema_extra=unit("mm")
    )

    def make_sensor(self) -> "RangeSensor":
        """None: the mill's pairs bring their range."""
        from appliance.sizing.range_sensor.sensor import NoRangeSensor

        return NoRangeSensor()


class ModbusRange(RangeSettings):
    """A laser whose range stands in a register of a Modbus TCP server."""

    kind: Literal["modbus"] = Field(description="A laser that is read over Modbus TCP")
    host: str = Field(min_length=1, description="Name or address of the sensor or its gateway")
    port: int = Field(default=502, ge=1, le=65535, description="Its TCP port")
    unit_id: int = Field(default=1, ge=0, le=255, description="Its unit")
    table: Literal["input", "holding"] = Field(default="input", description="Registers that hold the range")
    address: int = Field(ge=0, le=65535, description="Address of the range, counted from 0 as on the wire")
    words: int = Field(
        default=1,
        ge=1,
        le=2,
        description="Registers that the range takes, an unsigned whole number, most significant first",
    )
    scale_mm: float = Field(
        default=0.1, gt=0, le=1000, description="Millimetres per count", json_schema_extra=unit("mm")
    )
    offset_mm: float = Field(
        default=0.0, ge=-100000, le=100000, description="Added to count times scale", json_schema_extra=unit("mm")
    )
    measures_mm: Span = Field(
        default=[100.0, 6000.0],
        description="Least and greatest range; what lies outside is none: no target",
        json_schema_extra=unit("mm"),
    )
    age_max_ms: int = Field(
        default=50,
        ge=5,
        le=2000,
        description="Longest time between exposure and range; older ranges are not used",
        json_schema_extra=unit("ms"),
    )

    def make_sensor(self) -> "RangeSensor":
        """The sensor that a thread reads."""
        from appliance.sizing.range_sensor.modbus import ModbusRangeSensor

        return ModbusRangeSensor(self)


Range = Annotated[NoRange | MillRange | ModbusRange, Field(discriminator="kind")]
