"""From 8-bit code values back to linear light.

An edge lies where light is halfway between dark and bright. Halfway in code values lies elsewhere: left undecoded, the
diameter is off by 1 mm RMS (docs/studies/worth.json).
"""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

CLIPPED_CODE = 250  # chosen: from this 8-bit code value on a channel counts as overexposed, its light as lost
Response = Literal["srgb", "linear", "gamma 2.2"]


def decoding_table(response: Response) -> NDArray[np.float32]:
    """Linear light, 0 to 1, of every 8-bit code value.

    Parameters
    ----------
    response : {"srgb", "linear", "gamma 2.2"}
        How the camera coded light: IEC 61966-2-1, no coding, or a power law.

    Returns
    -------
    ndarray of float32, shape (256,)

    Raises
    ------
    ValueError
        `response` is none of the three.
    """
    code = np.arange(256) / 255.0
    if response == "linear":
        light = code
    elif response == "gamma 2.2":
        light = code**2.2
    elif response == "srgb":
        light = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
    else:
        raise ValueError(f'response is {response!r}; allowed are "srgb", "linear", "gamma 2.2"')
    return light.astype(np.float32)
