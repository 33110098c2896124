"""AdamW (arXiv:1711.05101) in numpy: our networks are so small that no library for it is needed."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

DECAY, MOMENTS, LEAST_MOMENT = 1e-4, (0.9, 0.999), 1e-8


class AdamW:
    """Changes parameters against the slopes of a loss.

    Parameters
    ----------
    parameters : list of ndarray of float32
        Changed in place.
    """

    def __init__(self, parameters: list[Array]) -> None:
        self._parameters = parameters
        self._first, self._second = ([np.zeros_like(one) for one in parameters] for _ in range(2))
        self._steps = 0

    def step(self, slopes: list[Array], rate: float) -> None:
        """Change all parameters once.

        Parameters
        ----------
        slopes : list of ndarray
            Of the loss, in the order of the parameters.
        rate : float
        """
        self._steps += 1
        for number, slope in enumerate(slopes):
            self._first[number] += (1 - MOMENTS[0]) * (slope - self._first[number])
            self._second[number] += (1 - MOMENTS[1]) * (slope**2 - self._second[number])
            unbiased = self._first[number] / (1 - MOMENTS[0] ** self._steps)
            spread = np.sqrt(self._second[number] / (1 - MOMENTS[1] ** self._steps)) + LEAST_MOMENT
            step = rate * (unbiased / spread + DECAY * self._parameters[number])
            self._parameters[number] -= step.astype(np.float32)
