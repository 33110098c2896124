"""Fusion of two aligned pictures by one of `METHODS`.

Examples
--------
Where one view is dark, the maximum shows the other view:

>>> import numpy as np
>>> from vision.fusion.methods import fuse
>>> left = np.array([[10, 200], [10, 200]], np.uint8)
>>> right = np.array([[90, 90], [90, 90]], np.uint8)
>>> fuse(left, right, "maximum").tolist()
[[90, 200], [90, 200]]
>>> fuse(left, right, "average").tolist()
[[50, 145], [50, 145]]
"""

from concurrent.futures import Executor
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from vision.fusion.fourier import fuse_spectra
from vision.fusion.multiscale import DEFAULT_SCALES, Scales, fuse_pyramids, fuse_wavelets
from vision.fusion.names import METHODS, Method
from vision.fusion.wavelets import WAVELETS, WaveletName
from vision.pictures import check_shape

MULTISCALE: tuple[Method, ...] = (*WAVELETS, "pyramid")

Sample = TypeVar("Sample", np.uint8, np.uint16, np.float32, np.float64)
Planes = NDArray[np.float32]

_TYPES = tuple(map(np.dtype, (np.uint8, np.uint16, np.float32, np.float64)))


def fuse(
    left: NDArray[Sample],
    right: NDArray[Sample],
    method: Method,
    *,
    scales: Scales = DEFAULT_SCALES,
    executor: Executor | None = None,
    periodic: bool = False,
) -> NDArray[Sample]:
    """Fuse two aligned pictures of one scene into one.

    Parameters
    ----------
    left, right : ndarray of uint8, uint16, float32 or float64, shape (rows, columns) or (rows, columns, 3)
        Same shape and type; the right one aligned to the left one. Channels are fused on their own.
    method : str
        "fft" (algorithm 14); a wavelet, "db2", "db4", "db8", "db16", "fk4", "fk6", "fk8", "fk18"; "pyramid"
        (Laplacian); or pixel by pixel "average", "minimum", "maximum".
    scales : Scales
        For wavelets and the pyramid; the others have none.
    executor : Executor, optional
        With at least two threads; transforms both views in parallel.
    periodic : bool
        Of "fft": as algorithm 14 prints it, without the strip that continues the pictures; see `fuse_spectra`.

    Returns
    -------
    ndarray, shape and type of `left`
        Computed in float32; integers rounded and held within their range, floats as they come: details of two
        views together may exceed what each of them reaches. A picture fused with itself is that picture, to rounding.

    Raises
    ------
    ValueError
        `method` is unknown; a picture has another type or shape, is empty, or holds values that are not finite; the
        two do not have the same shape and type.
    """
    if method not in METHODS:
        raise ValueError(f"method: {method!r} is none of {', '.join(METHODS)}")
    _check_picture("left", left)
    _check_picture("right", right)
    if left.shape != right.shape or left.dtype != right.dtype:
        raise ValueError(f"right: {_described(right)}, but left is {_described(left)}; both must be alike")
    planes = _planes(left), _planes(right)
    if method == "fft":
        return _like(left, fuse_spectra(*planes, executor, periodic=periodic))
    return _like(left, _fused(*planes, method, scales, executor))


def _fused(left: Planes, right: Planes, method: Method, scales: Scales, executor: Executor | None) -> Planes:
    if method == "pyramid":
        return fuse_pyramids(left, right, scales)
    if method == "average":
        return 0.5 * (left + right)
    if method == "minimum":
        return np.minimum(left, right)
    if method == "maximum":
        return np.maximum(left, right)
    return fuse_wavelets(left, right, cast("WaveletName", method), scales, executor)


def _check_picture(name: str, picture: NDArray[Any]) -> None:
    if picture.dtype not in _TYPES:
        raise ValueError(f"{name}: {picture.dtype} is none of {', '.join(map(str, _TYPES))}")
    check_shape(name, picture)
    if picture.dtype.kind == "f" and not np.isfinite(picture).all():
        raise ValueError(f"{name}: holds values that are not finite; fill them before fusing")


def _described(picture: NDArray[Any]) -> str:
    return f"{picture.dtype} of shape {picture.shape}"


def _planes(picture: NDArray[Any]) -> Planes:
    """Channels first, contiguous, float32."""
    planes = picture[None] if picture.ndim == 2 else picture.transpose(2, 0, 1)
    return np.ascontiguousarray(planes, dtype=np.float32)


def _like(picture: NDArray[Sample], fused: Planes) -> NDArray[Sample]:
    """Fused planes with the shape and type of a picture."""
    image = fused[0] if picture.ndim == 2 else fused.transpose(1, 2, 0)
    if picture.dtype.kind == "u":
        largest = np.iinfo(picture.dtype.name).max
        image = np.clip(np.rint(image), 0, largest)
    return np.ascontiguousarray(image, dtype=picture.dtype)
