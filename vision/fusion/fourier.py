"""Algorithm 14: of each frequency, the amplitude and phase of the view in which it is stronger.

A discrete Fourier transform takes pictures to be periodic. Where opposite borders differ, that is a step of every line,
and choosing frequency by frequency would mix the steps of both views into ripples all over the picture. The pictures
are therefore continued by a strip that fades from the mirrored picture at one border to that at the other; the strip
also brings the sides to lengths that transform fast, and is cut off at the end. As printed there is no strip.
"""

from concurrent.futures import Executor

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from vision.fusion.rules import fuse_coefficients

Planes = NDArray[np.float32]

LEAST_STRIP_PX = 16
WORKERS = 2


def fuse_spectra(left: Planes, right: Planes, executor: Executor | None = None, *, periodic: bool = False) -> Planes:
    """Fuse two pictures by the larger magnitude of each frequency (algorithm 14).

    Parameters
    ----------
    left, right : ndarray of float32, shape (channels, rows, columns)
    executor : Executor, optional
        Transforms both views at once; without, two threads share each of them.
    periodic : bool
        Whether the pictures are taken to be periodic, as printed; else they are continued by a strip.

    Returns
    -------
    ndarray of float32, shape (channels, rows, columns)
    """
    rows, columns = left.shape[1:]
    whole = (left, right) if periodic else (continued(left), continued(right))
    if executor is None:
        first, second = (_spectrum(planes, WORKERS) for planes in whole)
    else:
        first, second = executor.map(_spectrum, whole, (1, 1))
    fuse_coefficients(first, second, "larger")
    return _pictures(first, whole[0].shape[2])[:, :rows, :columns]


# One axis after the other, the second in place: a third faster than the two-dimensional functions, which copy.


def _spectrum(planes: Planes, workers: int) -> NDArray[np.complex64]:
    of_rows = fft.rfft(planes, axis=2, workers=workers)
    return np.asarray(fft.fft(of_rows, axis=1, overwrite_x=True, workers=workers), dtype=np.complex64)


def _pictures(spectrum: NDArray[np.complex64], columns: int) -> Planes:
    of_rows = fft.ifft(spectrum, axis=1, overwrite_x=True, workers=WORKERS)
    return np.asarray(fft.irfft(of_rows, columns, axis=2, overwrite_x=True, workers=WORKERS), dtype=np.float32)


def fast_length(length: int) -> int:
    """Length of a side with its strip: at least `LEAST_STRIP_PX` more, with small prime factors only."""
    return fft.next_fast_len(length + LEAST_STRIP_PX, real=True)  # pyright: ignore[reportReturnType]  its stub has no body


def continued(planes: Planes) -> Planes:
    """Pictures with strips at the end of both axes that lead back to their beginning without a step.

    Parameters
    ----------
    planes : ndarray of float32, shape (channels, rows, columns)

    Returns
    -------
    ndarray of float32, shape (channels, fast_length(rows), fast_length(columns))
    """
    channels, rows, columns = planes.shape
    whole = np.empty((channels, fast_length(rows), fast_length(columns)), dtype=np.float32)
    whole[:, :rows, :columns] = planes
    after, before, weight = _strip(columns, whole.shape[2])
    whole[:, :rows, columns:] = (1 - weight) * planes[:, :, after] + weight * planes[:, :, before]
    after, before, weight = _strip(rows, whole.shape[1])
    weight = weight[:, None]
    whole[:, rows:] = (1 - weight) * whole[:, after] + weight * whole[:, before]
    return whole


def _strip(length: int, whole: int) -> tuple[NDArray[np.int64], NDArray[np.int64], Planes]:
    """Mirrored places after the end and before the beginning, and the weight of the latter."""
    extra = whole - length
    mirrored = np.pad(np.arange(length), extra, mode="symmetric")
    weight = np.arange(1, extra + 1, dtype=np.float32) / np.float32(extra + 1)
    return mirrored[-extra:], mirrored[:extra], weight
