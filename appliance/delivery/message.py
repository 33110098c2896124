"""Lines between the supervisor and the process that delivers: rows and figures there, its state back."""

import math
from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from appliance.history.tables import Row
from appliance.processes.message import Messages, StateMessage, StationMessage

Value = bool | int | float | str | None


class RowLine(StationMessage):
    """A row that the history gets, too.

    Attributes
    ----------
    table : str
    values : dict
        By column; None for no value.
    """

    kind: Literal["row"] = "row"
    table: str
    values: dict[str, Value]

    @classmethod
    def of(cls, row: Row) -> "RowLine":
        """Line of a row."""
        return cls(table=row.table, values=without_nan(row.values))


class FiguresLine(StationMessage):
    """What the registers say now.

    Attributes
    ----------
    values : dict
        By name of the register; None for no value.
    faults, alarms : tuple of str
        Names of those that are active.
    rows_dropped : int
        Rows given up since the supervisor started, because this process did not read them.
    """

    kind: Literal["figures"] = "figures"
    values: dict[str, Value]
    faults: tuple[str, ...]
    alarms: tuple[str, ...]
    rows_dropped: int = 0


class DeliveryStatus(StationMessage):
    """The state of the process, once a second.

    Attributes
    ----------
    trouble : str
        What cannot be delivered, where and what to do; empty while all can.
    waiting : int
        Messages that the broker has not acknowledged.
    dropped : int
        Messages given up since the process started, because too many waited.
    """

    kind: Literal["delivery"] = "delivery"
    trouble: str
    waiting: int
    dropped: int


LINES: TypeAdapter[RowLine | FiguresLine] = TypeAdapter(Annotated[RowLine | FiguresLine, Field(discriminator="kind")])
MESSAGES: Messages[DeliveryStatus] = TypeAdapter(Annotated[StateMessage | DeliveryStatus, Field(discriminator="kind")])


def without_nan(values: Mapping[str, Value]) -> dict[str, Value]:
    """Values with None where there is no number: JSON has no NaN."""
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value for name, value in values.items()
    }
