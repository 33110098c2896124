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
        The same moment as wall time, ms since 1970 UTC.
    elapsed_ms : float
        Computing time of the reading.
    dropped : int
        Pairs and messages discarded since the process started, because newer ones were ready.
    simulated : bool
        Whether the pictures come from a simulation or a recording.
    stretch : int
        Number of the stretch of a recording without a break.
    reading : SizeReading
        Of the one bar; `several_bars` where there are more.
    bars : tuple of SizeReading
        Of bars side by side, each in the slot that it keeps; empty where there is one or none.
    faults : dict of str to str
        Faults with which the value is still served: names in the fault table, each with its detail.
    adjustment_mm : float
        Known error that was added to the diameter; 0 without a value.
    not_kept : str
        Why the last pictures of the black box could not be written; empty if they could.
    scale_sha256 : str
        SHA-256 of the rig file, or of the picture of the empty line, that the gauge was made from; empty without one.
    """

    kind: Literal["reading"] = "reading"
    sequence: int
    exposed_monotonic_s: float
    exposed_utc_ms: int
    elapsed_ms: float
    dropped: int
    simulated: bool
    stretch: int = 0
    reading: Annotated[SizeReading, NAN_AS_NULL]
    bars: tuple[Annotated[SizeReading, NAN_AS_NULL], ...] = ()
    faults: dict[str, str] = Field(default_factory=dict)
    adjustment_mm: float = 0.0
    not_kept: str = ""
    scale_sha256: str = ""


MESSAGES: Messages[ReadingMessage] = TypeAdapter(Annotated[StateMessage | ReadingMessage, Field(discriminator="kind")])
