"""Trust in a reading: a confidence index in percent, not a probability."""

from typing import Protocol

U_MAX_WITHOUT_TOLERANCE_MM = 0.25


class Judged(Protocol):
    """What the trust in a reading follows from; a reading and its message both have it."""

    @property
    def valid(self) -> bool:
        """Whether there is a value."""
        ...

    @property
    def windows_kept(self) -> int:
        """Windows that agree with it."""
        ...

    @property
    def windows_total(self) -> int:
        """All windows."""
        ...

    @property
    def expanded_uncertainty_mm(self) -> float | None:
        """U, mm."""
        ...

    @property
    def trust_limit(self) -> float:
        """Most that the trust may be, percent."""
        ...


def trust_percent(reading: Judged, allowed_mm: float = U_MAX_WITHOUT_TOLERANCE_MM) -> float:
    """Trust in a reading: 100 x kept / total x min(1, U_max / U), at most its limit; 0 without a value.

    Parameters
    ----------
    reading : SizeReading or ReadingMessage
    allowed_mm : float
        U_max.
    """
    expanded_mm = reading.expanded_uncertainty_mm
    if not reading.valid or not reading.windows_total or not expanded_mm:
        return 0.0
    trust = 100 * reading.windows_kept / reading.windows_total * min(1.0, allowed_mm / expanded_mm)
    return min(trust, reading.trust_limit)
