"""Coverage of U where several values share one rig, whose calibration and response are in all of their errors."""

import math


def inside_and_standard_error(rows):
    """Share of values inside U, and its standard error with a rig's values as one draw (ratio estimator).

    Parameters
    ----------
    rows : list of dict
        One of each rig, with `error_mm` and `expanded_mm`, equally long lists; None where a frame has no value.

    Returns
    -------
    dict
        `inside`, `inside_standard_error`.
    """
    rigs = [inside for inside in map(_inside, rows) if inside]
    count = sum(map(len, rigs))
    share = sum(map(sum, rigs)) / count
    squares = sum((sum(rig) - share * len(rig)) ** 2 for rig in rigs)
    error = math.sqrt(squares * len(rigs) / (len(rigs) - 1)) / count
    return {"inside": round(share, 4), "inside_standard_error": round(error, 4)}


def _inside(row):
    pairs = zip(row["error_mm"], row["expanded_mm"], strict=True)
    return [abs(error) <= expanded for error, expanded in pairs if error is not None]
