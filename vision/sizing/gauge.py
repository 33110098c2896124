"""The gauge: the bar's diameter by both routes, each judged by the other."""

import numpy as np
from numpy.typing import NDArray

from vision.calibration.rig import Rig
from vision.readings import SizeReading
from vision.sizing.tangent import TangentGauge

Image = NDArray[np.uint8]


class Gauge:
    """Measures one bar with a calibrated rig.

    Parameters
    ----------
    rig : Rig

    Raises
    ------
    ValueError
        The rig has no world frame, or a camera does not see the measuring region.
    """

    def __init__(self, rig: Rig) -> None:
        self._tangent = TangentGauge(rig)

    def measure(self, left: Image, right: Image) -> SizeReading:
        """Diameter of the bar in one pair of pictures, by route T.

        Parameters
        ----------
        left, right : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
            Raw pictures, grey or blue-green-red.

        Returns
        -------
        SizeReading
            See `TangentGauge.measure` for the reasons.

        Raises
        ------
        ValueError
            A picture is not 8 bit, not grey or three-channel, or not of the size that the rig was calibrated for.
        """
        return self._tangent.measure(left, right)
