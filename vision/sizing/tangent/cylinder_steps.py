"""Compiled: the gaps between rays and a cylinder, and the Gauss-Newton steps that narrow them.

One ray after the other, without temporary arrays: a fit takes some 15 steps over 2,000 rays, and the cost of a call on
arrays of that size is most of what numpy needs for them.
"""

import numpy as np
from numba import njit
from scipy.special import ndtri

from vision.geometry.robust_constants import BIWEIGHT_TUNING, SIGMA_PER_MAD

CONVERGED_STEP = 1e-4  # mm and mm per mm: the fit has converged when no parameter changes by more
QUIET_SHARE = 0.25  # chosen: the quietest quarter of a limb's neighbouring points surely lies on the bar's own edge
QUIET_SIGMAS = float(np.sqrt(2) * ndtri((1 + QUIET_SHARE) / 2))  # its largest difference, in standard deviations
LAG_POINTS = 4  # chosen: points of a limb this far apart, 4 px, share no blur, so that their noise is independent
# Chosen: the biweight's scale begins with the spread of all points (1.4826 MAD) and is multiplied by 0.7 in each of the
# first 8 steps, down to 0.6 of that spread or the quietest neighbours' scatter, so that the fit settles on the bar's
# edge.
NARROWING_ROUNDS, NARROWING_FACTOR, NARROWEST_FACTOR = 8, 0.7, 0.6
LEAST_SCALE_PX = 0.02  # chosen: least scale of the biweight; a chance scatter below it would reject good points
LARGEST_CONDITION = 1e12  # of the scaled normal equations: beyond it the rays fix no cylinder


@njit(nogil=True, cache=True)
def tangent_distance(parameters, origin, direction, side):  # type: ignore[no-untyped-def]
    """Gaps and their derivatives; see `vision.sizing.tangent.cylinder_fit.tangent_distance_mm`."""
    x0, z0, slope_x, slope_z, R = parameters
    gap, jacobian = np.empty(side.shape[0]), np.empty((side.shape[0], 5))
    for i in range(side.shape[0]):
        s = side[i]
        v_x, v_y, v_z = direction[i]
        w_x, w_y, w_z = x0 - origin[i, 0], -origin[i, 1], z0 - origin[i, 2]
        n_x, n_y, n_z = v_z - slope_z * v_y, slope_z * v_x - slope_x * v_z, slope_x * v_y - v_x  # u x v
        length = np.sqrt(n_x * n_x + n_y * n_y + n_z * n_z)
        d = (w_x * n_x + w_y * n_y + w_z * n_z) / length
        gap[i] = s * d - R
        jacobian[i, 0] = s * n_x / length
        jacobian[i, 1] = s * n_z / length
        # by u: v x w / |n| - (v x n) d / |n|^2
        jacobian[i, 2] = s * ((v_y * w_z - v_z * w_y) - (v_y * n_z - v_z * n_y) * d / length) / length
        jacobian[i, 3] = s * ((v_x * w_y - v_y * w_x) - (v_x * n_y - v_y * n_x) * d / length) / length
        jacobian[i, 4] = -1.0
    return gap, jacobian


@njit(nogil=True, cache=True)
def robust_steps(rays, start, rounds):  # type: ignore[no-untyped-def]
    """Gauss-Newton steps under Tukey's biweight until none changes the cylinder any more.

    Parameters
    ----------
    rays : tuple of ndarray
        Origin, direction, side, pixels per radian, factor on residuals inwards; and whether a ray and the one
        `LAG_POINTS` further are in the same window.
    start : ndarray of float64, shape (5,)
    rounds : int
        Limit on the steps.

    Returns
    -------
    tuple
        Whether the steps have converged; parameters, gaps, their derivatives, pixels per mm, residuals, weights, and
        the biweight's scale, all at the last step.
    """
    origin, direction, side, pixel_per_radian, inwards, near = rays
    count = side.shape[0]
    pixel_per_mm, residual_px, weight, spare = np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    parameters, scale_px, converged = start.copy(), np.inf, False
    gap, jacobian = tangent_distance(parameters, origin, direction, side)
    for number in range(rounds):
        if number > 0:
            gap, jacobian = tangent_distance(parameters, origin, direction, side)
        _scales(parameters, origin, direction, pixel_per_radian, pixel_per_mm)
        if not _all_finite(gap, pixel_per_mm, residual_px):
            break
        if number < NARROWING_ROUNDS:  # afterwards the scale is fixed, so that the steps converge
            scale_px = _narrowed_px(residual_px, near, number, spare)
        for i in range(count):
            ratio = (inwards[i] if residual_px[i] < 0 else 1.0) * residual_px[i] / scale_px
            weight[i] = (1 - (ratio / BIWEIGHT_TUNING) ** 2) ** 2 if abs(ratio) < BIWEIGHT_TUNING else 0.0
        if converged:
            return True, parameters, gap, jacobian, pixel_per_mm, residual_px, weight, scale_px
        step = _step(jacobian, gap, weight, pixel_per_mm)
        largest = np.abs(step).max()
        if not largest < np.inf:
            break
        parameters -= step
        converged = number >= NARROWING_ROUNDS and largest < CONVERGED_STEP
    return False, parameters, gap, jacobian, pixel_per_mm, residual_px, weight, scale_px


@njit(nogil=True, cache=True)
def _scales(parameters, origin, direction, pixel_per_radian, pixel_per_mm):  # type: ignore[no-untyped-def]
    """Scale of the picture at the axis, for every ray."""
    for i in range(pixel_per_mm.shape[0]):
        away_x, away_y, away_z = parameters[0] - origin[i, 0], -origin[i, 1], parameters[1] - origin[i, 2]
        depth = away_x * direction[i, 0] + away_y * direction[i, 1] + away_z * direction[i, 2]
        pixel_per_mm[i] = pixel_per_radian[i] / max(depth, 1.0)


@njit(nogil=True, cache=True)
def _all_finite(gap, pixel_per_mm, residual_px):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(gap.shape[0]):
        residual_px[i] = gap[i] * pixel_per_mm[i]
        total += abs(residual_px[i])
    return total < np.inf


@njit(nogil=True, cache=True)
def _narrowed_px(residual_px, near, number, spare):  # type: ignore[no-untyped-def]
    """Scale of the biweight in one of the first steps."""
    count = residual_px.shape[0]
    for i in range(count):
        spare[i] = abs(residual_px[i])
    low, high = _neighbouring_ranks(spare[:count], (count - 1) // 2)
    wide_px = SIGMA_PER_MAD * 0.5 * (low + (low if count % 2 else high))
    kept = 0
    for i in range(near.shape[0]):
        if near[i]:
            spare[kept] = abs(residual_px[i + LAG_POINTS] - residual_px[i])
            kept += 1
    local_px = 0.0
    if kept > 0:
        place = QUIET_SHARE * (kept - 1)
        below, above = _neighbouring_ranks(spare[:kept], int(place))
        local_px = (below + (above - below) * (place - int(place))) / QUIET_SIGMAS
    narrow_px = max(LEAST_SCALE_PX, local_px, NARROWEST_FACTOR * wide_px)
    return max(narrow_px, NARROWING_FACTOR**number * wide_px)


@njit(nogil=True, cache=True)
def _neighbouring_ranks(values, rank):  # type: ignore[no-untyped-def]
    """The value of a rank, from 0, and the next one, the same for the last; reorders the values (Hoare's selection)."""
    # as in vision/order_statistics.py, since compiled code is kept by file and would not see a change of another one
    low, high = 0, values.shape[0] - 1
    while low < high:
        pivot, i, j = values[(low + high) // 2], low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if rank <= j:
            high = j
        elif rank >= i:
            low = i
        else:
            break
    following = values[rank] if rank + 1 == values.shape[0] else values[rank + 1 :].min()
    return values[rank], following


@njit(nogil=True, cache=True)
def _step(jacobian, gap, weight, pixel_per_mm):  # type: ignore[no-untyped-def]
    """(J' W J)^-1 J' W times the gaps; NaN where the rays do not fix a cylinder."""
    normal, right = np.zeros((5, 5)), np.zeros(5)
    for i in range(gap.shape[0]):
        factor = weight[i] * pixel_per_mm[i] ** 2
        for row in range(5):
            weighted = jacobian[i, row] * factor
            right[row] += weighted * gap[i]
            for column in range(row + 1):
                normal[row, column] += weighted * jacobian[i, column]
    return _solved(normal, right)


@njit(nogil=True, cache=True)
def _solved(normal, right):  # type: ignore[no-untyped-def]
    """Solve by Cholesky's factors after scaling to a unit diagonal; `normal` holds the lower triangle.

    A pivot is at least the least eigenvalue, so one below 1 / `LARGEST_CONDITION` proves a larger condition number.
    """
    count = right.shape[0]
    size, lower, solution = np.sqrt(np.diag(normal)), np.zeros((count, count)), np.full(count, np.nan)
    if not size.min() > 0:
        return solution
    for row in range(count):
        for column in range(row + 1):
            rest = normal[row, column] / (size[row] * size[column])
            for k in range(column):
                rest -= lower[row, k] * lower[column, k]
            if row > column:
                lower[row, column] = rest / lower[column, column]
            elif rest > 1 / LARGEST_CONDITION:
                lower[row, row] = np.sqrt(rest)
            else:
                return solution
    inner = np.empty(count)
    for row in range(count):
        inner[row] = (right[row] / size[row] - (lower[row, :row] * inner[:row]).sum()) / lower[row, row]
    for row in range(count - 1, -1, -1):
        inner[row] = (inner[row] - (lower[row + 1 :, row] * inner[row + 1 :]).sum()) / lower[row, row]
        solution[row] = inner[row] / size[row]
    return solution
