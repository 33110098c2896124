"""Decision of conformity with the tolerance, and the uncertainty that a tolerance allows. Pure arithmetic."""

from appliance.conformity.set_points import SetPoints
from appliance.sizing.trust import U_MAX_WITHOUT_TOLERANCE_MM
from plc.codes import Decision

TOLERANCE_TO_U_RATIO = 8  # chosen: U_max is an eighth of the tolerance's width (docs/methods/trust.md)


def allowed_uncertainty_mm(points: SetPoints) -> float:
    """Largest expanded uncertainty that does not lower the trust, U_max, mm."""
    tolerance = points.tolerance_mm
    return U_MAX_WITHOUT_TOLERANCE_MM if tolerance is None else sum(tolerance) / TOLERANCE_TO_U_RATIO


def decide(deviation_mm: float, expanded_mm: float, tolerance_mm: tuple[float, float]) -> Decision:
    """Decide whether a size is in tolerance, with the guard band g = U on both sides of both limits.

    IN if the size lies inside both limits by at least U, OUT if it lies outside one by at least U, else UNDECIDED.

    Parameters
    ----------
    deviation_mm : float
        Size minus target.
    expanded_mm : float
        U of the size.
    tolerance_mm : tuple of float
        Allowed deviations above and below the target, both positive.
    """
    plus_mm, minus_mm = tolerance_mm
    inside_mm = min(plus_mm - deviation_mm, deviation_mm + minus_mm)
    if inside_mm >= expanded_mm:
        return Decision.IN
    return Decision.OUT if -inside_mm >= expanded_mm else Decision.UNDECIDED
