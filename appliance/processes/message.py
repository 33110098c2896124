"""Messages of a measuring process: what all have in common, the state of the process, and what it is asked for."""

from typing import Literal, TypeVar, cast

from pydantic import BaseModel, BeforeValidator, ConfigDict, TypeAdapter


class StationMessage(BaseModel):
    """Base of all messages: unknown fields and numbers that are not finite are refused; a message never changes."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class StateMessage(StationMessage):
    """The state of the measuring process.

    Attributes
    ----------
    state : str
        `starting`: the settings can be used and readings follow. `warming`: code is being compiled, which may last
        longer than the supervisor's limit of silence; the cameras are not open yet. `faulty`: `fault` prevents
        readings.
    fault : str
        Name in the fault table; empty without a fault.
    detail : str
        One sentence: what, where and what to do.
    """

    kind: Literal["state"] = "state"
    state: Literal["starting", "warming", "faulty"]
    fault: str = ""
    detail: str = ""


class KeepPictures(StationMessage):
    """Request of the supervisor: write the last seconds of pictures.

    Attributes
    ----------
    why : str
        Name of the cause.
    """

    kind: Literal["keep_pictures"] = "keep_pictures"
    why: str


MessageT = TypeVar("MessageT", bound=StationMessage)
Messages = TypeAdapter[StateMessage | MessageT]
"""Reads the lines of one kind of station: states and readings."""


def _without_nulls(fields: object) -> object:
    """Drop fields that are null, so that each has its default, NaN: JSON has no NaN."""
    if not isinstance(fields, dict):
        return fields
    return {name: value for name, value in cast("dict[str, object]", fields).items() if value is not None}


NAN_AS_NULL = BeforeValidator(_without_nulls)
"""Marks a reading inside a message: a value that is missing is NaN in Python and null on the link."""
