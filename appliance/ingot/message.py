"""Message of the ingot station to the supervisor."""

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from appliance.processes.message import NAN_AS_NULL, Messages, StateMessage, StationMessage
from vision.readings import OrientationReading


class IngotVerdict(StationMessage):
    """Decision on one ingot.

    Attributes
    ----------
    ingot : int
        Number of the ingot since the process started, from 1.
    orientation : str
    confidence : float
        Percent.
    ssim_top, ssim_bottom : float or None
        Means over the pictures that the decision counts.
    told_utc_ms : int
        Moment at which the decision, or the departure of an undecided ingot, was reported; ms since 1970 UTC.
    """

    ingot: int
    orientation: Literal["top", "bottom", "undecided"]
    confidence: float
    ssim_top: float | None
    ssim_bottom: float | None
    told_utc_ms: int


class IngotMessage(StationMessage):
    """One picture of the ingot line.

    Attributes
    ----------
    sequence : int
        Number of the exposure.
    exposed_monotonic_s : float
        Moment of exposure on this machine's monotonic clock.
    elapsed_ms : float
        Computing time of the reading.
    dropped : int
        Pictures and messages discarded since the process started.
    simulated : bool
        Whether the pictures come from a simulation or a recording.
    reading : OrientationReading
        Of this picture alone.
    current : IngotVerdict or None
        Of the ingot on the line; None without an ingot.
    told : tuple of IngotVerdict
        The last ingots that were decided or left undecided, oldest first. Each message repeats them, so that no ingot
        is lost with a message.
    faults : dict of str to str
        Faults with which the reading is still served: names in the fault table, each with its detail.
    not_kept : str
        Why the last pictures of the black box could not be written; empty if they could.
    """

    kind: Literal["ingot"] = "ingot"
    sequence: int
    exposed_monotonic_s: float
    elapsed_ms: float
    dropped: int
    simulated: bool
    reading: Annotated[OrientationReading, NAN_AS_NULL]
    current: IngotVerdict | None
    told: tuple[IngotVerdict, ...] = ()
    faults: dict[str, str] = Field(default_factory=dict)
    not_kept: str = ""


MESSAGES: Messages[IngotMessage] = TypeAdapter(Annotated[StateMessage | IngotMessage, Field(discriminator="kind")])
