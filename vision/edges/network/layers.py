"""Shape of the edge network, which training and inference share: a chain of convolutions at half resolution.

Dilated kernels (Yu and Koltun, arXiv:1511.07122) let 16 channels see 70 x 70 pixels, so that a patch of scale can be
told from a limb; the last layer's four planes are the four pixels of a cell.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

DARK_CODE = 0.02  # chosen: added to codes (0 to 1) before their logarithm, so that black noise stays small
MIDDLE_LOG = 2.0  # brings the logarithms near 0
CELL_PX = 2  # side of a cell: the first layer goes over every second row and column


class Layer(NamedTuple):
    """One convolution: side of its kernels, distance between what they see, planes in and out."""

    side: int
    dilation: int
    stride: int
    planes_in: int
    planes_out: int

    @property
    def padding(self) -> int:
        """Rows and columns of zeros on each side that keep the size."""
        return self.dilation * (self.side // 2)


LAYERS = (
    Layer(5, 1, CELL_PX, 3, 16),
    Layer(3, 1, 1, 16, 16),
    Layer(3, 2, 1, 16, 16),
    Layer(3, 4, 1, 16, 16),
    Layer(3, 8, 1, 16, 16),
    Layer(3, 1, 1, 16, CELL_PX**2),
)
# Pixels further away do not change a strength.
REACH_PX = CELL_PX * sum(layer.padding for layer in LAYERS[1:]) + LAYERS[0].padding + CELL_PX


def network_input(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """What the network is given: logarithms of the codes, in which a change of exposure is a constant.

    Parameters
    ----------
    image : ndarray of float32, shape (..., rows, columns, 3)
        Red-green-blue, 0 to 1; grey three times.

    Returns
    -------
    ndarray of float32, same shape
    """
    return np.log(image + np.float32(DARK_CODE)) + np.float32(MIDDLE_LOG)
