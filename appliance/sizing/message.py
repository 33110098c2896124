"""Message of the sizing station to the supervisor."""

from typing import Literal

from pydantic import Field

from appliance.processes.message import StationMessage


class ReadingMessage(StationMessage):
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
    faults: dict[str, str] = Field(default_factory=dict)
    trust_limit: float = 100.0
    windows_kept: int
    windows_total: int
    alignment_quality: float | None
    plane_height_mm: float | None
