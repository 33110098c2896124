"""Message of the sizing station to the supervisor."""

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from appliance.processes.message import NAN_AS_NULL, Messages, StateMessage, StationMessage
from vision.readings import SizeReading


class ReadingMessage(StationMessage):
    """One reading.

    Attributes
    ----------
    sequence : int
        Number of the exposure.
    exposed_monotonic_s : float
        Moment of exposure on this machine's monotonic clock.
    exposed_utc_ms : int
        The same for people, ms since 1970 UTC.
    elapsed_ms : float
        Time that measuring took.
    dropped : int
        Pairs and readings discarded since the process started, because newer ones were there.
    simulated : bool
    reading : SizeReading
        What was measured.
    faults : dict of str to str
        Faults that leave the value standing: names in the fault table, and what exactly is wrong.
    """

    kind: Literal["reading"] = "reading"
    sequence: int
    exposed_monotonic_s: float
    exposed_utc_ms: int
    elapsed_ms: float
    dropped: int
    simulated: bool
    reading: Annotated[SizeReading, NAN_AS_NULL]
    faults: dict[str, str] = Field(default_factory=dict)


MESSAGES: Messages[ReadingMessage] = TypeAdapter(Annotated[StateMessage | ReadingMessage, Field(discriminator="kind")])
