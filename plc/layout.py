"""Packs rows that stand side by side into words, and unpacks them."""

import struct
from collections.abc import Iterable, Sequence
from operator import itemgetter

from plc.rows import STRUCT_CODES, Register, WordOrder, span


class Layout:
    """Contiguous rows, packed and unpacked in one go.

    Parameters
    ----------
    rows : sequence of Register
        By address, without a hole.

    Attributes
    ----------
    rows : list of Register
        Those that are not spare.
    span : range
        Addresses of the words.
    """

    def __init__(self, rows: Sequence[Register]) -> None:
        self.rows = [row for row in rows if not row.spare]
        self.span = span(rows)
        self._numbers = struct.Struct(">" + "".join("2x" if r.spare else STRUCT_CODES[r.type] for r in rows))
        self._words = struct.Struct(f">{len(self.span)}H")
        swapped = (word for row in rows for word in reversed(range(row.address, row.end)))
        self._swap = itemgetter(*(word - self.span.start for word in swapped))

    def pack(self, numbers: Iterable[float], word_order: WordOrder) -> bytes:
        """Words of one number for each of `rows`, most significant byte of each word first."""
        return self._in_order(self._numbers.pack(*numbers), word_order)

    def unpack(self, words: bytes, word_order: WordOrder) -> dict[str, float | int]:
        """Numbers in the words, by name of the row."""
        numbers = self._numbers.unpack(self._in_order(words, word_order))
        return {row.name: number for row, number in zip(self.rows, numbers, strict=True)}

    def _in_order(self, words: bytes, word_order: WordOrder) -> bytes:
        if word_order == "big":
            return words
        if word_order == "little":
            return self._words.pack(*self._swap(self._words.unpack(words)))
        raise ValueError(f'word_order: {word_order!r} is neither "big" nor "little"')
