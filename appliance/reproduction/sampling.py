"""Figures of the report with their sampling errors, and what they say of a finding of the dissertation."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from appliance.comparison.sizes import share_interval
from appliance.reproduction.experiment import number

CLEAR_ERRORS = 2.0  # standard errors by which a difference must exceed 0 before it confirms or contradicts


def mean_with_error(values: Sequence[float | None], form: str = ".2f") -> str:
    """Mean and its standard error, "0.39 ± 0.04"; without the latter for one value, "-" for none.

    Parameters
    ----------
    values : sequence of float or None
        Independent of each other; None and NaN are left out.
    form : str
        Of `format`, for the mean.
    """
    there = _there(values)
    if not there.size:
        return "-"
    mean = number(float(there.mean()), form)
    return mean if there.size < 2 else f"{mean} ± {number(_standard_error(there), form.lstrip('+'))}"


def rms_with_error(errors: Sequence[float | None], form: str = ".2f") -> str:
    """Root mean square and its standard error (first order), written as `mean_with_error` does.

    Parameters
    ----------
    errors : sequence of float or None
    form : str
    """
    there = _there(errors)
    if not there.size:
        return "-"
    rms = float(np.sqrt(np.mean(there**2)))
    if there.size < 2 or rms == 0:
        return number(rms, form)
    return f"{number(rms, form)} ± {number(_standard_error(there**2) / (2 * rms), form)}"


def share(part: int, whole: int) -> str:
    """A share with Wilson's interval of 95 %: "3 of 24 (4 to 31 %)".

    Parameters
    ----------
    part, whole : int
    """
    if not whole:
        return "0 of 0"
    low, high = (100 * min(max(bound, 0.0), 1.0) for bound in share_interval(part, whole))
    return f"{part} of {whole} ({low:.0f} to {high:.0f} %)"


def verdict(differences: Sequence[float | None]) -> str:
    """What paired differences, positive where the dissertation is right, say of its finding.

    Parameters
    ----------
    differences : sequence of float or None
        One of each independent draw; None and NaN are left out.

    Returns
    -------
    str
        "confirmed" or "contradicted" where the mean is more than two standard errors off 0, else "not decided".
    """
    there = _there(differences)
    if there.size < 2 or abs(there.mean()) <= CLEAR_ERRORS * _standard_error(there):
        return "not decided by so few"
    return "confirmed" if there.mean() > 0 else "contradicted"


def _there(values: Sequence[float | None]) -> NDArray[np.float64]:
    whole = np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    return whole[np.isfinite(whole)]


def _standard_error(values: NDArray[np.float64]) -> float:
    return float(values.std(ddof=1) / np.sqrt(values.size))
