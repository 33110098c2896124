"""Messages that any measuring process sends: their base and the state of the process."""

from typing import Literal

from pydantic import BaseModel, ConfigDict


class StationMessage(BaseModel):
    """What every message has: no unknown fields, no numbers that are not finite, not changed once it is made."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class StateMessage(StationMessage):
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
