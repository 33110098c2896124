"""Size of the bar at 20 °C from its hot size."""

import math
from typing import NamedTuple

from appliance.conformity.set_points import SetPoints
from appliance.conformity.thermal_expansion import GRADES


class Size(NamedTuple):
    """A diameter and its expanded uncertainty (k = 2), mm."""

    diameter_mm: float
    expanded_mm: float


def cold_size(hot: Size, points: SetPoints, temperature_u_c: float) -> Size | None:
    """Size at 20 °C: cold = hot / (1 + e), with the elongation e (EN 1993-1-2) at the section's mean temperature.

    Parameters
    ----------
    hot : Size
    points : SetPoints
    temperature_u_c : float
        Standard uncertainty u (k = 1) of the temperature, °C. It contributes half the change of the cold size
        between one u below and one u above (GUM 5.1.3, note 2), which also holds across the bends of the curve.

    Returns
    -------
    Size or None
        None without a temperature or a grade, and for a grade that is not in `GRADES`.
    """
    if points.grade not in GRADES or points.temperature_c is None:
        return None
    elongation = GRADES[points.grade].elongation
    factor, cooler, hotter = (
        1 / (1 + elongation(points.temperature_c + change)) for change in (0, -temperature_u_c, temperature_u_c)
    )
    u_temperature_mm = hot.diameter_mm * (cooler - hotter) / 2
    return Size(hot.diameter_mm * factor, math.hypot(hot.expanded_mm * factor, 2 * u_temperature_mm))


def judged_size(hot: Size, cold: Size | None, points: SetPoints) -> Size | None:
    """Size to compare with target and tolerances: cold if a grade is set, else hot.

    Parameters
    ----------
    hot : Size
    cold : Size or None
        From `cold_size`; None if it cannot be computed, which then gives None.
    points : SetPoints
    """
    return hot if points.grade is None else cold
