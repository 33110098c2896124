"""What a measuring process says to the supervisor: small messages, one JSON line each, no images.

The supervisor may read any number of them late and the process may die in the middle of one; neither may
stop the other. So the process never waits on the link (what cannot be sent is dropped and counted), and the
supervisor uses the newest.
"""

import socket
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter


class _Message(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class StateMessage(_Message):
    """The state of the measuring process.

    Attributes
    ----------
    state : str
        `starting`: the settings can be used, readings will follow; `warming`: code is compiled, which may take longer
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


class ReadingMessage(_Message):
    """One reading; a value that does not exist is None.

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
    valid : bool
        Whether the diameter may be used.
    reasons : int
        Bits of `reason_word`.
    faults : dict of str to str
        Faults that leave the value standing: names in the fault table, and what exactly is wrong.
    trust_limit : float
        Most that the trust may be, in percent, whatever windows and uncertainty say.
    """

    kind: Literal["reading"] = "reading"
    sequence: int
    exposed_monotonic_s: float
    exposed_utc_ms: int
    elapsed_ms: float
    dropped: int
    simulated: bool
    valid: bool
    reasons: int
    diameter_mm: float | None
    expanded_uncertainty_mm: float | None
    diameter_virtual_board_mm: float | None
    weighted_deviation_mm: float | None
    faults: dict[str, str] = {}
    trust_limit: float = 100.0
    windows_kept: int
    windows_total: int
    alignment_quality: float | None
    plane_height_mm: float | None


class IngotVerdict(_Message):
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


class IngotMessage(_Message):
    """One picture of the ingot line; a value that does not exist is None.

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
    present : bool
        Whether an end lies on the line.
    reasons : int
        Bits of `ingot_reason_word`.
    ssim_top, ssim_bottom : float or None
        Of this picture.
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
    present: bool
    reasons: int
    ssim_top: float | None
    ssim_bottom: float | None
    current: IngotVerdict | None
    told: tuple[IngotVerdict, ...] = ()
    faults: dict[str, str] = {}


Message = StateMessage | ReadingMessage | IngotMessage
_MESSAGE: TypeAdapter[Message] = TypeAdapter(Annotated[Message, Field(discriminator="kind")])


def parse(line: bytes) -> Message:
    """Message of one line; raises ValueError when the line is not one."""
    return _MESSAGE.validate_json(line)


class StationLink:
    """The measuring process's end of the link.

    Parameters
    ----------
    connection : socket.socket
        Connected stream socket; its receiving side stays untouched.
    """

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._unsent = b""
        self.dropped = 0
        """Messages that could not be sent because the supervisor did not read."""

    def send(self, message: Message) -> None:
        """Send a message now or drop it; never waits, never raises when the other side is gone."""
        self._flush()
        if self._unsent:
            self.dropped += 1
            return
        self._unsent = message.model_dump_json().encode() + b"\n"
        self._flush()

    def _flush(self) -> None:
        if not self._unsent:
            return
        try:
            sent = self._connection.send(self._unsent, socket.MSG_DONTWAIT | socket.MSG_NOSIGNAL)
        except OSError:
            return  # full, or the supervisor is gone: who watches the link ends this process then
        self._unsent = self._unsent[sent:]
