"""The circle of an ingot's end: a vote of edge points (algorithm 16), and a sub-pixel fit to its lower arc.

Only the lower half of the end stands out from the line; above it lies the ingot's own body.
"""

from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.order_statistics import column_medians, median

Array = NDArray[np.float64]

EDGE_SHARE = 0.2  # chosen: gradients below 20 % of the strongest are texture and noise
VOTE_SMOOTHING_PX = 5  # chosen: side of the square over which votes for a centre are averaged
RAY_COUNT = 61  # chosen: rays to the lower arc, one every 3 degrees or so
RAY_STEP_PX = 0.5  # chosen: distance of the samples along a ray
MOST_FIT_ROUNDS = 8  # chosen: points that still change after so many rounds lie on no circle
ARC_TOLERANCE_SHARE = 0.04  # chosen, of the radius, and at least a pixel: points further off belong to something else


class Circle(NamedTuple):
    """Centre (x, y) and radius in pixels of the array that it was found in."""

    x: float
    y: float
    radius: float


def vote_for_circle(warmth: NDArray[np.uint8], hot: NDArray[np.uint8], radius_px: tuple[float, float]) -> Circle | None:
    """Hough transform of lower edges: each votes for centres along its gradient, then for the radius (algorithm 16).

    Parameters
    ----------
    warmth : ndarray of uint8, shape (rows, columns)
        Bright where it is hot.
    hot : ndarray of uint8, shape (rows, columns)
        Not 0 on hot pixels; edges elsewhere do not vote.
    radius_px : tuple of float
        Smallest and largest radius.

    Returns
    -------
    Circle or None
        None when there is no lower edge.
    """
    rows, columns = warmth.shape
    smooth = cv2.GaussianBlur(warmth, (5, 5), 0)
    gradient_x, gradient_y = (cv2.Sobel(smooth, cv2.CV_16S, *order) for order in ((1, 0), (0, 1)))
    near = cv2.dilate(hot, np.ones((5, 5), np.uint8))
    edges = cv2.Canny(gradient_x, gradient_y, *_canny_levels(gradient_x, gradient_y), L2gradient=True)
    y, x = np.nonzero((edges > 0) & (near > 0) & (gradient_y < 0))
    if x.size == 0:
        return None
    along = np.stack([gradient_x[y, x], gradient_y[y, x]]).astype(float)
    along /= np.hypot(*along)
    radii = np.arange(radius_px[0], radius_px[1] + 1)
    center_x = np.rint(x[:, None] + along[0][:, None] * radii).astype(int)
    center_y = np.rint(y[:, None] + along[1][:, None] * radii).astype(int)
    inside = (center_x >= 0) & (center_x < columns) & (center_y >= 0) & (center_y < rows)
    votes = np.bincount((center_y * columns + center_x)[inside], minlength=rows * columns).reshape(rows, columns)
    votes = cv2.blur(votes.astype(np.float32), (VOTE_SMOOTHING_PX, VOTE_SMOOTHING_PX))
    best_y, best_x = np.unravel_index(int(np.argmax(votes)), votes.shape)
    return _with_radius(float(best_x), float(best_y), np.stack([x, y]).astype(float), along, radii)


def _canny_levels(gradient_x: NDArray[Any], gradient_y: NDArray[Any]) -> tuple[float, float]:
    strongest = float(np.hypot(gradient_x.astype(np.float32), gradient_y.astype(np.float32)).max())
    return 0.5 * EDGE_SHARE * strongest, EDGE_SHARE * strongest


def _with_radius(x: float, y: float, points: Array, along: Array, radii: Array) -> Circle | None:
    """Vote for the radius among the edges that point to the centre."""
    to_center = np.array([[x], [y]]) - points
    distance = np.hypot(*to_center)
    points_there = np.sum(to_center * along, axis=0) > 0.95 * distance
    votes, _ = np.histogram(distance[points_there], np.append(radii, radii[-1] + 1) - 0.5)
    votes = np.convolve(votes, np.ones(3), mode="same")
    return Circle(x, y, float(radii[np.argmax(votes)])) if votes.max() > 0 else None


def fit_lower_arc(warmth: NDArray[np.uint8], start: Circle, arc: float) -> Circle | None:
    """Circle through the half-level edge below and beside an end, fitted robustly.

    Parameters
    ----------
    warmth : ndarray of uint8, shape (rows, columns)
        Bright where it is hot.
    start : Circle
        First guess, good to about a quarter of the radius.
    arc : float
        Least share of the lower half circle that must lie on the circle.

    Returns
    -------
    Circle or None
        None when less of the arc is there.
    """
    circle = start
    for _ in range(2):
        edge_x, edge_y = _lower_edge(warmth, circle)
        fitted = _robust_circle(edge_x, edge_y, arc * RAY_COUNT)
        if fitted is None or not 0.5 * start.radius < fitted.radius < 1.5 * start.radius:
            return None
        circle = fitted
    return circle


def _lower_edge(warmth: NDArray[np.uint8], circle: Circle) -> tuple[Array, Array]:
    """First half-level crossing outwards along each ray; rays without one are left out."""
    angle = np.linspace(np.radians(-5), np.radians(185), RAY_COUNT)
    radius = np.arange(0.6 * circle.radius, 1.5 * circle.radius, RAY_STEP_PX)
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    map_x = (circle.x + radius * cosine).astype(np.float32)
    map_y = (circle.y + radius * sine).astype(np.float32)
    rays = cv2.remap(warmth, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).astype(float)
    inner = rays.shape[1] // 4
    level = (column_medians(rays[:, :inner].T) + np.min(rays, axis=1)) / 2
    below = rays < level[:, None]
    below[:, :inner] = False
    first = np.argmax(below, axis=1)
    ray = np.flatnonzero(first > 0)
    after, before = rays[ray, first[ray]], rays[ray, first[ray] - 1]
    share = (before - level[ray]) / np.maximum(before - after, 1e-9)
    edge = radius[0] + RAY_STEP_PX * (first[ray] - 1 + np.clip(share, 0, 1))
    return circle.x + edge * np.cos(angle[ray]), circle.y + edge * np.sin(angle[ray])


def _least_squares(x: Array, y: Array) -> Circle:
    """Circle x^2 + y^2 = a x + b y + c through points, after Kåsa; about their mean, so that it is well conditioned."""
    middle_x, middle_y = x.mean(), y.mean()
    x, y = x - middle_x, y - middle_y
    design = np.column_stack([x, y, np.ones(x.size)])
    normal = design.T @ design + np.diag([1e-9, 1e-9, 0])  # points on a line: a huge circle, which is refused later
    a, b, c = np.linalg.solve(normal, design.T @ (x**2 + y**2))
    radius = float(np.sqrt(max(c + (a**2 + b**2) / 4, 0)))
    return Circle(float(middle_x + a / 2), float(middle_y + b / 2), radius)


def _robust_circle(x: Array, y: Array, least: float) -> Circle | None:
    """Least squares, repeated on the points that lie near; None when fewer than `least` do."""
    near = np.ones(x.size, bool)
    for _ in range(MOST_FIT_ROUNDS):
        if np.count_nonzero(near) < max(least, 3):
            return None
        circle = _least_squares(x[near], y[near])
        off = np.abs(np.hypot(x - circle.x, y - circle.y) - circle.radius)
        tolerance = max(1.0, ARC_TOLERANCE_SHARE * circle.radius)
        before, near = near, off < max(tolerance, 2 * median(off[near]))
        if np.array_equal(near, before):
            return circle if np.count_nonzero(off < tolerance) >= least else None
    return None
