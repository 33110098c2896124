"""Messages of a measuring process: what all have in common, and the state of the process."""

from typing import Literal, TypeVar, cast

from pydantic import BaseModel, BeforeValidator, ConfigDict, TypeAdapter


class StationMessage(BaseModel):
    """What every message has: no unknown fields, no numbers that are not finite, not changed once it is made."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class StateMessage(StationMessage):
    """The state of the measuring process.

    Attributes
    ----------
    state : str
        `starting`: the settings can be used, readings will follow; `warming`: code is compiled, which may last longer
        than silence is allowed, and nothing is known yet of the cameras; `faulty`: no readings, because of `fault`.
    fault : str
        Name in the fault table; empty without a fault.
    detail : str
        One sentence: what, where and what to do.
    """

    kind: Literal["state"] = "state"
    state: Literal["starting", "warming", "faulty"]
    fault: str = ""
    detail: str = ""


MessageT = TypeVar("MessageT", bound=StationMessage)
Messages = TypeAdapter[StateMessage | MessageT]
"""Reads the lines of one kind of station: states and readings."""


def _without_nulls(fields: object) -> object:
    """Leave out what is null: JSON has no NaN, and a field that is missing has its default, which is NaN."""
    if not isinstance(fields, dict):
        return fields
    return {name: value for name, value in cast("dict[str, object]", fields).items() if value is not None}


NAN_AS_NULL = BeforeValidator(_without_nulls)
"""Marks a reading inside a message; its values that do not exist are NaN here and null on the link."""
