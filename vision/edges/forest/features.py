"""Features of the structured forest: 7228 features of a 32 x 32 pixel patch, read from smoothed channels.

A place (i, j) on the grid of cells (2 x 2 pixels) stands for the patch whose label mask covers the rows 2i to 2i + 15
and the columns 2j to 2j + 15 of the picture; the patch itself reaches 8 pixels further on every side. Features, as in
Dollar and Zitnick, "Fast Edge Detection Using Structured Forests", section 3.2, numbered as OpenCV's format does:

- id < 3328: one lightly smoothed channel value; channel = id // 256, column = id % 256 // 16, row = id % 16.
- id >= 3328: self-similarity; of each channel in turn the difference A - B of two cells of the strongly smoothed
  channel, for all pairs A before B of a 5 x 5 grid with the coordinates 1, 4, 8, 11, 14, counted down the columns.
"""

from typing import cast

import numpy as np
from numpy.typing import NDArray

from vision.edges.forest import channels
from vision.edges.forest.rings import new_rings

PATCH_PX = 32
LABEL_PX = 16
PATCH_CELLS = PATCH_PX // 2
REGULAR_FEATURES = channels.CHANNELS * PATCH_CELLS**2
_GRID = np.array([1, 4, 8, 11, 14])
_PAIR_FIRST, _PAIR_SECOND = np.triu_indices(len(_GRID) ** 2, 1)
PAIRS = len(_PAIR_FIRST)
FEATURES = REGULAR_FEATURES + channels.CHANNELS * PAIRS

Floats = NDArray[np.float32]
Integers = NDArray[np.int64]


def checked_image(image: Floats) -> Floats:
    """The picture as a contiguous array of shape (rows, columns, 1 or 3).

    Raises
    ------
    TypeError
        `image` is no array of float32.
    ValueError
        It is neither grey, (rows, columns), nor RGB, (rows, columns, 3), or smaller than a patch.
    """
    if not isinstance(cast("object", image), np.ndarray) or image.dtype != np.float32:
        kind = getattr(image, "dtype", type(image).__name__)
        raise TypeError(f"image is of {kind}; wanted is an array of float32 with values 0 to 1")
    if image.ndim == 2:
        image = image[:, :, None]
    if image.ndim != 3 or image.shape[2] not in (1, 3):
        raise ValueError(f"image has the shape {image.shape}; wanted is (rows, columns) or (rows, columns, 3)")
    if min(image.shape[:2]) < PATCH_PX:
        raise ValueError(f"image has {image.shape[0]} rows and {image.shape[1]} columns; both must reach {PATCH_PX}")
    return np.require(image, requirements=("C", "A", "W"))  # other layouts would have the kernels compiled again


def check_values(outside: int) -> None:
    """Raise ValueError if values outside 0 to 1 (or NaN) were met in the picture."""
    if outside:
        raise ValueError(f"image has values outside 0 to 1, or NaN, in {outside} of the places that were read")


def smoothed_cells(image: Floats) -> Floats:
    """All cells of a picture: what `sample` reads features from.

    Parameters
    ----------
    image : ndarray of float32, shape (rows, columns) or (rows, columns, 3)
        Grey or RGB, 0 to 1.

    Returns
    -------
    ndarray of float32, shape (cell rows, 27, cells)
        Planes 0 to 12 are the channels (L, u, v, magnitude, 4 orientations, the last five again at half scale)
        smoothed by [1 2 1] / 4, 13 to 25 the same smoothed by a triangle of radius 4, 26 is zero. The grid begins
        8 pixels above and left of the picture. A grey picture has the u and v of grey.

    Raises
    ------
    TypeError, ValueError
        As `checked_image`; or a value is outside 0 to 1 or NaN.
    """
    image = checked_image(image)
    rows, columns, colours = image.shape
    cell_rows, width = channels.cells_along(rows), channels.cells_along(columns)
    cells = np.empty((cell_rows, channels.PLANES, width), np.float32)
    rings, done = new_rings(width, colours), channels.stages_starting_at(0)
    check_values(channels.make_cell_rows(image, 0, 0, cell_rows, rings, done, cells))
    return cells


def places_along(pixels: int) -> int:
    """Places on the grid along a side of so many pixels."""
    return channels.cells_along(pixels) - PATCH_CELLS


def feature_offsets(feature_ids: Integers, width: int) -> tuple[Integers, Integers]:
    """Where the two operands of features lie in flattened cells, counted from a place's first cell in plane 0.

    Parameters
    ----------
    feature_ids : ndarray of int, any shape
    width : int
        Cells a row, the last dimension of `smoothed_cells`.

    Returns
    -------
    first, second : ndarray of int64, shape of `feature_ids`
        The feature is first - second; the second of a regular feature lies in the plane of zeros.
    """
    ids = np.asarray(feature_ids, np.int64)
    row_stride = channels.PLANES * width
    regular = ids < REGULAR_FEATURES
    channel, place = np.divmod(ids, PATCH_CELLS**2)
    column, row = np.divmod(place, PATCH_CELLS)
    single = row * row_stride + channel * width + column
    pair_channel, pair = np.divmod(np.where(regular, 0, ids - REGULAR_FEATURES), PAIRS)
    plane = (channels.CHANNELS + pair_channel) * width

    def grid_offset(cell: Integers) -> Integers:
        return _GRID[cell % len(_GRID)] * row_stride + plane + _GRID[cell // len(_GRID)]

    first = np.where(regular, single, grid_offset(_PAIR_FIRST[pair]))
    second = np.where(regular, channels.ZERO_PLANE * width, grid_offset(_PAIR_SECOND[pair]))
    return first, second


def sample(cells: Floats, places: Integers, feature_ids: Integers | None = None) -> Floats:
    """Features of the patches at given places.

    Parameters
    ----------
    cells : ndarray of float32
        From `smoothed_cells`.
    places : ndarray of int, shape (patches, 2)
        (i, j) on the grid, 0 <= i < places_along(rows), 0 <= j < places_along(columns).
    feature_ids : ndarray of int, shape (features,), optional
        Numbers of the features; all 7228 by default.

    Returns
    -------
    ndarray of float32, shape (patches, features)

    Raises
    ------
    ValueError
        A place or an id lies outside its range.
    """
    cell_rows, planes, width = cells.shape
    places = np.asarray(places, np.int64)
    ids = np.arange(FEATURES) if feature_ids is None else np.asarray(feature_ids, np.int64)
    if ((places < 0) | (places >= (cell_rows - PATCH_CELLS, width - PATCH_CELLS))).any():
        raise ValueError("places do not all lie on the grid")
    if ((ids < 0) | (ids >= FEATURES)).any():
        raise ValueError(f"feature_ids are not all within 0 to {FEATURES - 1}")
    first, second = feature_offsets(ids, width)
    flat = cells.reshape(-1)
    base = (places[:, 0] * planes * width + places[:, 1])[:, None]
    return flat[base + first] - flat[base + second]
