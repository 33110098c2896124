"""A picture that shows its own moment: what a camera would see of a bar and of a clock beside it.

The picture of a moment is a function of it alone, so a receiver can tell when it was exposed, and whether it is whole.
"""

import time

import numpy as np

BITS = 32  # of milliseconds on the monotonic clock, which all processes of a computer share
DARK, BRIGHT = 40, 200
GRAIN = 10  # of the scale on a bar, which makes a picture as large as a camera's
BAR_TRAVEL_PX = 0.3  # of the bar in a millisecond
BLOCK = 16
WHOLE_BLOCK = 20  # mean difference of a block that coding explains; a concealed one is off by more


def clock_picture(moment_ms, columns, rows):
    """Grey picture, shape (rows, columns), uint8: a row of bits above, a bar that moves below."""
    picture = np.full((rows, columns), DARK, np.uint8)
    cell = columns // BITS
    for bit in range(BITS):
        if moment_ms >> bit & 1:
            picture[: rows // 4, bit * cell : (bit + 1) * cell] = BRIGHT
    left = int(moment_ms * BAR_TRAVEL_PX) % (columns // 2)
    scale = np.random.default_rng(5).integers(-GRAIN, GRAIN, (rows - rows // 4, columns // 4))
    picture[rows // 4 :, left : left + columns // 4] = BRIGHT + scale
    return picture


def shown_ms(picture):
    """Moment that a received picture shows, milliseconds on the monotonic clock."""
    rows, columns = picture.shape[:2]
    cell = columns // BITS
    half = (DARK + BRIGHT) / 2
    light = [
        np.median(picture[rows // 16 : rows // 5, bit * cell + cell // 4 : (bit + 1) * cell - cell // 4])
        for bit in range(BITS)
    ]
    return sum(1 << bit for bit, level in enumerate(light) if level > half)


def damage(picture):
    """Largest mean difference of a block of 16 x 16 pixels from the picture of the moment that is shown."""
    rows, columns = picture.shape[:2]
    apart = np.abs(picture.astype(float) - clock_picture(shown_ms(picture), columns, rows))
    blocks = apart[: rows // BLOCK * BLOCK, : columns // BLOCK * BLOCK]
    blocks = blocks.reshape(rows // BLOCK, BLOCK, columns // BLOCK, BLOCK)
    return float(blocks.mean(axis=(1, 3)).max())


def now_ms():
    return int(time.monotonic() * 1000)
