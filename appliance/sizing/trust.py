"""Trust in a reading: a confidence index in percent, not a probability."""

from vision.readings import SizeReading

U_MAX_WITHOUT_TOLERANCE_MM = 0.25  # chosen: U_max while the PLC has set no tolerance (docs/methods/trust.md)


def trust_percent(reading: SizeReading, allowed_mm: float = U_MAX_WITHOUT_TOLERANCE_MM) -> float:
    """Trust in a reading, percent: 100 x kept / total x min(1, U_max / U), at most its limit; 0 without a value.

    Parameters
    ----------
    reading : SizeReading
    allowed_mm : float
        U_max, the largest expanded uncertainty that does not lower the trust, mm.
    """
    expanded_mm = reading.expanded_uncertainty_mm
    if not reading.valid or not reading.windows_total or not expanded_mm > 0:
        return 0.0
    trust = 100 * reading.windows_kept / reading.windows_total * min(1.0, allowed_mm / expanded_mm)
    return min(trust, reading.trust_limit)
