"""The 13 channels of a picture, smoothed twice, row by row: what the forest's features are read from.

Rows flow through rings of the last few rows of every stage, so that the whole chain stays in the processor's cache:
lightness and colour -> gradients at full and at half scale -> normalised magnitudes -> histograms of orientation ->
smoothed channels ("cells", at half resolution). No stage depends on anything but the rows within its reach, so a part
of a picture gives the same bits as the whole.

Channels in order: L, u, v | magnitude and its four orientations at full scale | the same at half scale.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.edges.forest.rings import ORIENTATIONS, REACH, RING, UNSMOOTHED

CHANNELS = 13
PLANES = 2 * CHANNELS + 1  # lightly smoothed, strongly smoothed, and a plane of zeros
ZERO_PLANE = 2 * CHANNELS
PAD_PX = 8
_LAST = RING - 1

_FLAT = np.float32(1e-5)
_TAN_22_5 = np.float32(0.414124)  # where OpenCV's arctangent, right to 0.01 degrees, passes 22.5 degrees: 0.414214
_NORMALISATION = np.float32(0.01)

_TABLE_STEPS = 1024
_SCALE = 1.0 / 270.0
_U_ZERO = np.float32(88 * _SCALE)
_V_ZERO = np.float32(134 * _SCALE)
_U_WHITE, _V_WHITE = np.float32(0.197833), np.float32(0.468331)


def _lightness_table() -> NDArray[np.float32]:
    """CIE lightness L* / 270 of luminance 0 to 1, in 1024 steps, and once more for 1 itself."""
    luminance = np.arange(_TABLE_STEPS) / _TABLE_STEPS
    bright = luminance > (6 / 29) ** 3
    lightness = np.where(bright, 116 * np.cbrt(luminance) - 16, (29 / 3) ** 3 * luminance)
    return (_SCALE * np.append(lightness, lightness[-1])).astype(np.float32)


_LIGHTNESS = _lightness_table()


def stages_starting_at(cell_row: int) -> NDArray[np.int64]:
    """The next row of L, u, v, of gradients at full and half scale, and of channels, if `cell_row` is wanted first."""
    channel = max(0, cell_row - REACH)
    half = max(0, channel - REACH)
    return np.array([2 * max(0, half - 1), max(0, 2 * channel - REACH), half, channel], np.int64)


@njit(nogil=True, cache=True)
def cells_along(pixels):
    """Cells along one side of a picture: padded by 8 pixels at both ends, and by one more if the side is odd."""
    return (pixels + 2 * PAD_PX + 1) // 2


@njit(nogil=True, cache=True)
def _mirrored(index, length):
    """Index of the value that stands in for one outside 0 to length - 1: ... 1 0 | 0 1 2 ... | last last ..."""
    if index < 0:
        return -1 - index
    if index >= length:
        return 2 * length - 1 - index
    return index


@njit(nogil=True, cache=True)
def _reflected(index, length):
    """The same without repeating the outermost value: ... 2 1 | 0 1 2 ... | last, last - 1 ..."""
    if index < 0:
        return -index
    if index >= length:
        return 2 * length - 2 - index
    return index


@njit(nogil=True, cache=True)
def _grey_row(picture, lightness):
    outside = 0
    for x in range(picture.shape[0]):
        luminance = picture[x]
        inside = (luminance >= np.float32(0)) & (luminance <= np.float32(1))
        outside += not inside
        lightness[x] = _LIGHTNESS[int(np.float32(_TABLE_STEPS) * luminance)] if inside else np.float32(0)
    return outside


@njit(nogil=True, cache=True)
def _colour_row(picture, row_l, row_u, row_v):
    """RGB to L, u, v, each scaled to 0 to 1."""
    outside = 0
    for column in range(picture.shape[0]):
        r, g, b = picture[column, 0], picture[column, 1], picture[column, 2]
        inside = (min(r, g, b) >= np.float32(0)) & (max(r, g, b) <= np.float32(1)) & (r + g + b < np.float32(4))
        if not inside:
            outside += 1
            continue
        x = np.float32(0.430574) * r + np.float32(0.341550) * g + np.float32(0.178325) * b
        y = np.float32(0.222015) * r + np.float32(0.706655) * g + np.float32(0.071330) * b
        z = np.float32(0.020183) * r + np.float32(0.129553) * g + np.float32(0.939180) * b
        lightness = _LIGHTNESS[min(int(np.float32(_TABLE_STEPS) * y), _TABLE_STEPS)]
        share = np.float32(13) / (x + np.float32(15) * y + np.float32(3) * z + np.float32(1e-35))
        row_l[column] = lightness
        row_u[column] = lightness * (np.float32(4) * x * share - np.float32(13) * _U_WHITE) + _U_ZERO
        row_v[column] = lightness * (np.float32(9) * y * share - np.float32(13) * _V_WHITE) + _V_ZERO
    return outside


@njit(nogil=True, cache=True)
def _pad_row(row, begin, end, first, columns):
    """Fill what lies beyond the picture: mirrored, after one more value where `columns`, the picture's, are odd.

    `row` holds the columns from `first` on, behind one value; those from `begin` to `end` are filled already. The
    outermost values are repeated once.
    """
    even = columns + (columns & 1)
    for x in range(first, begin):
        row[x - first + 1] = row[_mirrored(x, even) - first + 1]
    for x in range(end, first + row.shape[0] - 2):
        row[x - first + 1] = row[min(_mirrored(x, even), columns - 1) - first + 1]
    row[0] = row[1]
    row[-1] = row[-2]


@njit(nogil=True, cache=True)
def _luv_row(image, first_cell, padded_row, rings):
    """L, u, v of one row of the padded picture, from a cell on; gives the number of values outside 0 to 1."""
    rows, columns = image.shape[:2]
    row = min(_mirrored(padded_row - PAD_PX, rows + (rows & 1)), rows - 1)
    luv, ring_row = rings.luv, padded_row & _LAST
    first = 2 * first_cell - PAD_PX
    begin, end = max(first, 0), min(first + luv.shape[2] - 2, columns)
    picture = image[row, begin:end]
    inner = slice(begin - first + 1, end - first + 1)
    if luv.shape[0] == 1:
        outside = _grey_row(picture[:, 0], luv[0, ring_row, inner])
    else:
        outside = _colour_row(picture, luv[0, ring_row, inner], luv[1, ring_row, inner], luv[2, ring_row, inner])
    for plane in range(luv.shape[0]):
        _pad_row(luv[plane, ring_row], begin, end, first, columns)
    return outside


@njit(nogil=True, cache=True)
def _half_luv_row(rings, cell_row):
    """Means of 2 x 2 pixels, into the ring at half scale and into the first channels."""
    upper, lower = (2 * cell_row) & _LAST, (2 * cell_row + 1) & _LAST
    ring_row = cell_row & _LAST
    luv, half_luv = rings.luv, rings.half_luv
    cells = rings.channels.shape[2]
    for plane in range(luv.shape[0]):
        first, second, half = luv[plane, upper], luv[plane, lower], half_luv[plane, ring_row]
        for x in range(cells):
            half[x + 1] = np.float32(0.25) * (
                (first[2 * x + 1] + second[2 * x + 1]) + (first[2 * x + 2] + second[2 * x + 2])
            )
        half[0] = half[1]
        half[cells + 1] = half[cells]
        rings.channels[plane, ring_row] = half[1 : cells + 1]


@njit(nogil=True, cache=True)
def _polar(dx, dy, square):
    """Magnitude and orientation bin (0 near 0 degrees, then in steps of 45) of one gradient."""
    across, along = abs(dx), abs(dy)
    slanted = 1 if dx * dy > np.float32(0) else 3
    orientation = 0 if along < _TAN_22_5 * across else slanted
    orientation = 2 if (across < _TAN_22_5 * along) | (across + along < _FLAT) else orientation
    return np.sqrt(square), np.int32(orientation)


@njit(nogil=True, cache=True)
def _grey_gradient_row(above, here, below, magnitude, orientation):
    for x in range(magnitude.shape[0]):
        dx = here[x + 2] - here[x]
        dy = below[x + 1] - above[x + 1]
        magnitude[x], orientation[x] = _polar(dx, dy, dx * dx + dy * dy)


@njit(nogil=True, cache=True)
def _colour_gradient_row(luv, above, here, below, magnitude, orientation):
    """Of the plane with the largest magnitude, the first one if equal."""
    plane_l, plane_u, plane_v = luv[0], luv[1], luv[2]
    for x in range(magnitude.shape[0]):
        dx = plane_l[here, x + 2] - plane_l[here, x]
        dy = plane_l[below, x + 1] - plane_l[above, x + 1]
        square = dx * dx + dy * dy
        dx_u = plane_u[here, x + 2] - plane_u[here, x]
        dy_u = plane_u[below, x + 1] - plane_u[above, x + 1]
        square_u = dx_u * dx_u + dy_u * dy_u
        dx = dx_u if square_u > square else dx
        dy = dy_u if square_u > square else dy
        square = max(square, square_u)
        dx_v = plane_v[here, x + 2] - plane_v[here, x]
        dy_v = plane_v[below, x + 1] - plane_v[above, x + 1]
        square_v = dx_v * dx_v + dy_v * dy_v
        dx = dx_v if square_v > square else dx
        dy = dy_v if square_v > square else dy
        square = max(square, square_v)
        magnitude[x], orientation[x] = _polar(dx, dy, square)


@njit(nogil=True, cache=True)
def _gradient_row(luv, row, rows, magnitude, orientation):
    above, here, below = _mirrored(row - 1, rows) & _LAST, row & _LAST, _mirrored(row + 1, rows) & _LAST
    if luv.shape[0] == 1:
        _grey_gradient_row(luv[0, above], luv[0, here], luv[0, below], magnitude[here], orientation[here])
    else:
        _colour_gradient_row(luv, above, here, below, magnitude[here], orientation[here])


@njit(nogil=True, cache=True)
def _strongly_smoothed_row(ring, row, rows, column_sums, smoothed):
    """Triangle filter of radius 4 in both directions; beyond the border values are reflected."""
    width = smoothed.shape[0]
    sums = column_sums[REACH : REACH + width]
    middle = ring[row & _LAST]
    one_up, one_down = ring[_reflected(row - 1, rows) & _LAST], ring[_reflected(row + 1, rows) & _LAST]
    two_up, two_down = ring[_reflected(row - 2, rows) & _LAST], ring[_reflected(row + 2, rows) & _LAST]
    three_up, three_down = ring[_reflected(row - 3, rows) & _LAST], ring[_reflected(row + 3, rows) & _LAST]
    four_up, four_down = ring[_reflected(row - 4, rows) & _LAST], ring[_reflected(row + 4, rows) & _LAST]
    for x in range(width):
        sums[x] = (
            np.float32(5) * middle[x]
            + np.float32(4) * (one_up[x] + one_down[x])
            + np.float32(3) * (two_up[x] + two_down[x])
        )
    for x in range(width):
        sums[x] += np.float32(2) * (three_up[x] + three_down[x]) + (four_up[x] + four_down[x])
    for x in range(REACH):
        column_sums[x] = column_sums[2 * REACH - x]
        column_sums[REACH + width + x] = column_sums[REACH + width - 2 - x]
    for x in range(width):
        smoothed[x] = np.float32(1 / 625) * (
            np.float32(5) * column_sums[x + 4]
            + np.float32(4) * (column_sums[x + 3] + column_sums[x + 5])
            + np.float32(3) * (column_sums[x + 2] + column_sums[x + 6])
            + np.float32(2) * (column_sums[x + 1] + column_sums[x + 7])
            + (column_sums[x] + column_sums[x + 8])
        )


@njit(nogil=True, cache=True)
def _lightly_smoothed_row(ring, row, rows, column_sums, smoothed):
    """[1 2 1] / 4 in both directions; beyond the border values are reflected."""
    width = smoothed.shape[0]
    middle = ring[row & _LAST]
    up, down = ring[_reflected(row - 1, rows) & _LAST], ring[_reflected(row + 1, rows) & _LAST]
    for x in range(width):
        column_sums[x + 1] = np.float32(2) * middle[x] + (up[x] + down[x])
    column_sums[0] = column_sums[2]
    column_sums[width + 1] = column_sums[width - 1]
    for x in range(width):
        smoothed[x] = np.float32(1 / 16) * (np.float32(2) * column_sums[x + 1] + (column_sums[x] + column_sums[x + 2]))


@njit(nogil=True, cache=True)
def _histogram_row(magnitude, orientation, row, rows, weight, scratch):
    """Adds one row's normalised magnitudes to the four rows `scratch[2:]`, each to the row of its orientation."""
    here = row & _LAST
    width = magnitude.shape[1]
    norm = scratch[1, :width]
    _strongly_smoothed_row(magnitude, row, rows, scratch[0], norm)
    strengths, bins = magnitude[here], orientation[here]
    for x in range(width):
        norm[x] = weight * strengths[x] / (norm[x] + _NORMALISATION)
    for turn in range(ORIENTATIONS):
        total = scratch[2 + turn]
        for x in range(width):
            total[x] += norm[x] if bins[x] == turn else np.float32(0)


@njit(nogil=True, cache=True)
def _orientation_channels(rings, cell_row, rows):
    """Histograms of one row of cells: of 2 x 2 pixels at full scale, of one pixel at half scale."""
    ring_row = cell_row & _LAST
    channels, scratch = rings.channels, rings.scratch
    cells = channels.shape[2]
    scratch[2:] = np.float32(0)
    for row in (2 * cell_row, 2 * cell_row + 1):
        _histogram_row(rings.magnitude, rings.orientation, row, rows, np.float32(0.25), scratch)
    for turn in range(ORIENTATIONS):
        total, channel = scratch[2 + turn], channels[3 + turn, ring_row]
        for x in range(cells):
            channel[x] = total[2 * x] + total[2 * x + 1]
    scratch[2:, :cells] = np.float32(0)
    _histogram_row(rings.half_magnitude, rings.half_orientation, cell_row, rows // 2, np.float32(1), scratch)
    for turn in range(ORIENTATIONS):
        channels[3 + ORIENTATIONS + turn, ring_row] = scratch[2 + turn, :cells]


@njit(nogil=True, cache=True)
def _smoothed_cells(rings, cell_row, cell_rows, cells):
    """One row of cells, `cells` of shape (PLANES, at least as many columns as there are cells)."""
    channels, scratch = rings.channels, rings.scratch
    width = channels.shape[2]
    if rings.luv.shape[0] == 1:
        channels[1, cell_row & _LAST] = _U_ZERO
        channels[2, cell_row & _LAST] = _V_ZERO
    for strong in range(2):
        first = CHANNELS * strong
        for source in range(UNSMOOTHED):
            plane = first + source + (source >= 3) + (source >= 3 + ORIENTATIONS)
            if rings.luv.shape[0] == 1 and 1 <= source <= 2:
                cells[plane, :width] = channels[source, cell_row & _LAST]
            elif strong:
                _strongly_smoothed_row(channels[source], cell_row, cell_rows, scratch[0], cells[plane, :width])
            else:
                _lightly_smoothed_row(channels[source], cell_row, cell_rows, scratch[0], cells[plane, :width])
        for magnitude in (first + 3, first + 4 + ORIENTATIONS):
            for x in range(width):
                cells[magnitude, x] = (cells[magnitude + 1, x] + cells[magnitude + 2, x]) + (
                    cells[magnitude + 3, x] + cells[magnitude + 4, x]
                )
    cells[ZERO_PLANE] = np.float32(0)


@njit(nogil=True, cache=True)
def _luv_rows_to(end, image, first_cell, rings, done):
    outside = 0
    while done[0] < end:
        outside += _luv_row(image, first_cell, done[0], rings)
        if done[0] & 1:
            _half_luv_row(rings, done[0] >> 1)
        done[0] += 1
    return outside


@njit(nogil=True, cache=True)
def _next_cell_row(image, first_cell, cell_row, rings, done, cells):
    rows = 2 * cells_along(image.shape[0])
    outside = 0
    while done[3] < min(cell_row + REACH + 1, rows // 2):
        channel = done[3]
        while done[1] < min(2 * channel + 2 + REACH, rows):
            outside += _luv_rows_to(min(done[1] + 2, rows), image, first_cell, rings, done)
            _gradient_row(rings.luv, done[1], rows, rings.magnitude, rings.orientation)
            done[1] += 1
        while done[2] < min(channel + 1 + REACH, rows // 2):
            outside += _luv_rows_to(min(2 * done[2] + 4, rows), image, first_cell, rings, done)
            _gradient_row(rings.half_luv, done[2], rows // 2, rings.half_magnitude, rings.half_orientation)
            done[2] += 1
        _orientation_channels(rings, channel, rows)
        done[3] += 1
    _smoothed_cells(rings, cell_row, rows // 2, cells)
    return outside


@njit(nogil=True, cache=True)
def make_cell_rows(image, first_cell, first, end, rings, done, cells):
    """Make some rows of cells; rows must be asked for one after another.

    Parameters
    ----------
    image : ndarray of float32, shape (rows, columns, 1 or 3)
    first_cell : int
        Where each row begins on the grid of the whole padded picture; it is as wide as `rings`.
    first, end : int
        Rows of the padded picture at half resolution.
    rings, done
        What earlier rows left, see `Rings` and `stages_starting_at`.
    cells : ndarray of float32, shape (at least end - first, PLANES, width)
        Where the rows go; width at least that of `rings`.

    Returns
    -------
    int
        How many values outside 0 to 1 were met.
    """
    outside = 0
    for cell_row in range(first, end):
        outside += _next_cell_row(image, first_cell, cell_row, rings, done, cells[cell_row - first])
    return outside
