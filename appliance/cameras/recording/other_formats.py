"""What the heads of TIFF, BMP and PGM files say: their size, their bits, how many pictures they hold."""

import re
from typing import Literal, NamedTuple

TIFF_ORDERS: dict[bytes, Literal["little", "big"]] = {b"II*\0": "little", b"MM\0*": "big"}
TIFF_ENTRY_BYTES = 12
TIFF_WIDTH, TIFF_HEIGHT = 256, 257  # tags (TIFF 6.0, section 8)
TIFF_SHORT = 3
BMP_START, BMP_HEAD_BYTES = b"BM", 26
NUMBER = rb"\s+(?:#[^\n]*\n\s*)*(\d+)"
PGM_HEAD = re.compile(rb"P[256]" + 3 * NUMBER + rb"\s")


class OtherHead(NamedTuple):
    """Head of a file.

    Attributes
    ----------
    size : tuple of int
        (columns, rows).
    bits : int or None
        Of a code value, where the file says it.
    pictures : int
        1, or more than one.
    """

    size: tuple[int, int]
    bits: int | None = None
    pictures: int = 1


def read_other_head(data: bytes) -> OtherHead | None:
    """Head of a TIFF, BMP or PGM file; None where it is none of them, or breaks off."""
    if found := PGM_HEAD.match(data[:4096]):
        columns, rows, greatest = map(int, found.groups())
        return OtherHead((columns, rows), max(8, greatest.bit_length()))
    if data.startswith(BMP_START) and len(data) >= BMP_HEAD_BYTES:
        columns, rows = (int.from_bytes(data[place : place + 4], "little", signed=True) for place in (18, 22))
        return OtherHead((abs(columns), abs(rows)))
    order = TIFF_ORDERS.get(data[:4])
    return None if order is None else _tiff_head(data, order)


def _tiff_head(data: bytes, order: Literal["little", "big"]) -> OtherHead | None:
    """Head of a TIFF file: a list of entries for each picture, each list with the place of the next (TIFF 6.0, 2)."""

    def number(place: int, length: int) -> int:
        return int.from_bytes(data[place : place + length], order)

    place, pictures, size = number(4, 4), 0, {TIFF_WIDTH: 0, TIFF_HEIGHT: 0}
    while 0 < place < len(data) - 2 and pictures < 2:
        pictures += 1
        entries = range(place + 2, place + 2 + TIFF_ENTRY_BYTES * number(place, 2), TIFF_ENTRY_BYTES)
        for entry in entries if pictures == 1 else ():
            if number(entry, 2) in size:
                size[number(entry, 2)] = number(entry + 8, 2 if number(entry + 2, 2) == TIFF_SHORT else 4)
        place = number(entries.stop, 4)
    return OtherHead((size[TIFF_WIDTH], size[TIFF_HEIGHT]), pictures=pictures) if pictures else None
