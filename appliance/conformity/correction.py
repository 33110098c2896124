"""Advised change of the stand's gap."""

from appliance.conformity.settings import CorrectionSettings


def wanted_correction_mm(deviation_mm: float, settings: CorrectionSettings) -> float:
    """Change of the stand's gap that would answer a deviation: -gain x deviation, clamped, 0 in the dead band."""
    if abs(deviation_mm) <= settings.dead_band_mm:
        return 0.0
    wanted_mm = -settings.gain * deviation_mm
    return max(-settings.limit_mm, min(settings.limit_mm, wanted_mm))


def towards(wanted_mm: float, before_mm: float, most_mm: float) -> float:
    """`wanted_mm`, or as near to it as a change of at most `most_mm` leads."""
    return max(before_mm - most_mm, min(before_mm + most_mm, wanted_mm))
