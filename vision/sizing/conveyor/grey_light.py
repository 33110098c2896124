"""Light of a picture of the line, in as many steps as the camera sent."""

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.pictures import grey
from vision.sent_picture import Codes, SentPicture

Plane = NDArray[np.float32]


def grey_light(picture: SentPicture | Codes, response_exponent: float = 1.0) -> Plane:
    """Light, 0 to 1, of a picture: of grey and luma as they were sent, of a mosaic and of colours their grey.

    Parameters
    ----------
    picture : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
        Grey, or blue-green-red.
    response_exponent : float
        Code values follow light to this power; 1 for a linear camera.

    Returns
    -------
    ndarray of float32, shape (rows, columns)
    """
    sent = SentPicture.of(picture)
    coding = sent.coding
    if coding.samples == "mosaic":
        light = np.multiply(grey(sent.shown), np.float32(1 / 255), dtype=np.float32)
    else:
        whole = coding.samples == "colour"
        codes = cv2.cvtColor(sent.measured, cv2.COLOR_BGR2GRAY) if whole else sent.measured[:, :, 0]
        above = np.maximum(codes, coding.black) - coding.black
        light = np.multiply(above, np.float32(1 / (coding.white - coding.black)), dtype=np.float32)
        light = np.minimum(light, np.float32(1))
    return light if response_exponent == 1.0 else light ** np.float32(1 / response_exponent)
