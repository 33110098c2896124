"""Advised correction of the stand's gap, mm; positive opens it."""

from appliance.conformity.settings import CorrectionSettings


def wanted_correction_mm(deviation_mm: float, settings: CorrectionSettings) -> float:
    """Correction of a deviation: -gain x deviation, clamped to `limit_mm`, 0 in the dead band.

    Parameters
    ----------
    deviation_mm : float
        Size minus target.
    settings : CorrectionSettings
    """
    if abs(deviation_mm) <= settings.dead_band_mm:
        return 0.0
    wanted_mm = -settings.gain * deviation_mm
    return max(-settings.limit_mm, min(settings.limit_mm, wanted_mm))


def rate_limited_mm(wanted_mm: float, before_mm: float, largest_change_mm: float) -> float:
    """Wanted correction, or the nearest one that a change of at most `largest_change_mm` reaches.

    Parameters
    ----------
    wanted_mm, before_mm : float
        Wanted correction, and the one in force.
    largest_change_mm : float
    """
    return max(before_mm - largest_change_mm, min(before_mm + largest_change_mm, wanted_mm))
