"""What readings of a bar do not share, and how far it averages out in their mean."""

import math

from vision.readings import SizeReading

LEAST_COUNT_SCATTER = 4  # chosen: fewer readings say too little of their scatter


def own_uncertainty_mm(reading: SizeReading) -> float:
    """Standard uncertainty of a diameter that it does not share with other readings: of the edges and of motion."""
    return math.hypot(stated(reading.u_edge_mm), stated(reading.u_motion_mm))


def stated(u_mm: float) -> float:
    """0 for a part of the uncertainty that a method does not state."""
    return u_mm if math.isfinite(u_mm) else 0.0


def mean_variance_factor(neighbours: float, count: int) -> float:
    """Variance of a mean over that of independent values, from the correlation r of neighbours: (1 + r) / (1 - r).

    That of a first-order autoregression (Bayley and Hammersley, doi:10.2307/2983560); to the sample's r the bias of
    short series is added back, (1 + 3 r) / n (Kendall, doi:10.2307/2333193), and it is not below 0.

    Parameters
    ----------
    neighbours : float
        r of the sample: sum of products of neighbours' distances from the mean over the sum of their squares.
    count : int
        n, number of values, at least 2.
    """
    r = min(max(neighbours + (1 + 3 * max(neighbours, 0.0)) / count, 0.0), 1 - 2 / count)
    return (1 + r) / (1 - r)
