"""What a diameter means against the set points: cold size, trust, decision, correction. Pure arithmetic."""

from appliance.conformity.set_points import SetPoints
from appliance.sizing.trust import U_MAX_WITHOUT_TOLERANCE_MM
from plc.codes import Decision

SHARE_OF_TOLERANCE = 8  # U_max is this part of the tolerance's width


def allowed_uncertainty_mm(points: SetPoints) -> float:
    """U_max, the expanded uncertainty that costs no trust."""
    tolerance = points.tolerance_mm
    return U_MAX_WITHOUT_TOLERANCE_MM if tolerance is None else sum(tolerance) / SHARE_OF_TOLERANCE


def decide(deviation_mm: float, expanded_mm: float, tolerance_mm: tuple[float, float]) -> Decision:
    """Whether a size is in tolerance, with the guard band g = U on both sides of both limits.

    Parameters
    ----------
    deviation_mm : float
        Size minus target.
    expanded_mm : float
        U of the size.
    tolerance_mm : tuple of float
        Allowed above and below the target, both positive.
    """
    plus_mm, minus_mm = tolerance_mm
    inside_mm = min(plus_mm - deviation_mm, deviation_mm + minus_mm)
    if inside_mm >= expanded_mm:
        return Decision.IN
    return Decision.OUT if -inside_mm >= expanded_mm else Decision.UNDECIDED
