"""Message of the ingot station to the supervisor."""

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from appliance.processes.message import NAN_AS_NULL, Messages, StateMessage, StationMessage
from vision.readings import OrientationReading


class IngotVerdict(StationMessage):
    """What was decided of one ingot.

    Attributes
    ----------
    ingot : int
        Number of the ingot since the process started, from 1.
    orientation : str
    confidence : float
        Percent.
    ssim_top, ssim_bottom : float or None
        Means over the pictures that counted.
    told_utc_ms : int
        Moment of the decision, or of the ingot's leaving undecided.
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
        Time that reading the picture took.
    dropped : int
        Pictures and messages discarded since the process started.
    simulated : bool
    reading : OrientationReading
        What this picture alone says.
    current : IngotVerdict or None
        What is known of the ingot on the line.
    told : tuple of IngotVerdict
        The last ingots that were decided or left undecided, oldest first; the same ones come again, so that none is
        lost with a message.
    faults : dict of str to str
        Faults that leave the picture standing, by name, with what exactly is wrong.
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


MESSAGES: Messages[IngotMessage] = TypeAdapter(Annotated[StateMessage | IngotMessage, Field(discriminator="kind")])
