"""Columns of the files that commands write: names, units, rounding and meaning; documents are derived from them."""

import math
from typing import NamedTuple

from appliance.files.row_writer import Value


class FileColumn(NamedTuple):
    """One column of a file.

    Attributes
    ----------
    name : str
        As it stands in CSV and JSON.
    unit : str
        Empty for a number without one, a text, or true and false.
    places : int or None
        Decimals that are written; None for what is no decimal number.
    text : str
        What it means, for people.
    """

    name: str
    unit: str
    places: int | None
    text: str

    def written(self, value: Value) -> Value:
        """Value as it is written: rounded, and None for one that does not exist."""
        if not isinstance(value, float):
            return value
        return round(value, self.places) if math.isfinite(value) else None
