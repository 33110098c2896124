"""Reading of JSON objects whose every fault becomes one sentence that names the key."""

import difflib
import json
import math
from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

MOST_COUNT = 65_535  # columns and rows of the largest pictures; no count is an amount of memory to ask for
LONGEST_NUMBER = 300  # digits; what is longer is not finite as a floating-point number


class Fields:
    """A JSON object read key by key; every method raises `ValueError` naming the key and what is wrong with it.

    Parameters
    ----------
    values : object
        What the JSON text held; anything but an object is refused.
    where : str
        Name of the object in the sentences, empty for the whole text.
    """

    def __init__(self, values: object, where: str = "") -> None:
        self._prefix = f"{where}." if where else ""
        if not isinstance(values, dict):
            sentence = f"{where or 'the text'}: a JSON object is needed, not {type(values).__name__}"
            raise ValueError(sentence)  # noqa: TRY004  the text is at fault, not the call
        self._values: dict[str, Any] = values

    @classmethod
    def of_text(cls, text: str) -> "Fields":
        """Parse a JSON text; `NaN` and `Infinity`, which are no JSON, are refused."""
        try:
            return cls(json.loads(text, parse_constant=_refuse_constant, parse_int=_short_number))
        except json.JSONDecodeError as error:
            raise ValueError(f"not well-formed JSON: {error}") from error
        except RecursionError as error:
            raise ValueError("not a file of ours: objects are nested too deeply") from error

    def __contains__(self, key: str) -> bool:
        """Whether the object has a key."""
        return key in self._values

    def refuse_others(self, known: Sequence[str]) -> None:
        """Raise `ValueError` for a key that is not known, with the nearest that is."""
        for key in self._values:
            if key not in known:
                near = difflib.get_close_matches(key, known, n=1)
                self.refuse(
                    key, f"unknown; did you mean {near[0]}?" if near else f"unknown; known are {', '.join(known)}"
                )

    def value(self, key: str) -> Any:
        """Value of a key that must be there."""
        if key not in self._values:
            raise ValueError(f"{self._prefix}{key}: missing")
        return self._values[key]

    def section(self, key: str) -> "Fields":
        """Object inside this one."""
        return Fields(self.value(key), f"{self._prefix}{key}")

    def number(self, key: str) -> float:
        """Read a finite number."""
        value = self.value(key)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            self.refuse(key, f"a finite number is needed, not {value!r}")
        return float(value)

    def number_or_none(self, key: str) -> float | None:
        """Read a finite number; None where the key is not there."""
        return self.number(key) if key in self else None

    def flag(self, key: str) -> bool:
        """Read true or false."""
        value = self.value(key)
        if not isinstance(value, bool):
            self.refuse(key, f"true or false is needed, not {value!r}")
        return value

    def pair_of_counts(self, key: str) -> tuple[int, int]:
        """Two whole numbers from 1 to `MOST_COUNT`."""
        value = self.value(key)
        whole = isinstance(value, list) and all(isinstance(v, int) and not isinstance(v, bool) for v in value)
        if not whole or len(value) != 2 or not 1 <= min(value) <= max(value) <= MOST_COUNT:
            self.refuse(key, f"two whole numbers from 1 to {MOST_COUNT} are needed, not {value!r}")
        return value[0], value[1]

    def array(self, key: str, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
        """Finite float64 array of a shape.

        Parameters
        ----------
        key : str
        shape : tuple of int or None
            None stands for any length, and such an array may be empty.
        """
        value = self.value(key)
        try:
            array = np.array(value, dtype=np.float64)
        except (TypeError, ValueError):
            self.refuse(key, "an array of numbers is needed")
        if None in shape and array.size == 0:
            return np.empty([length or 0 for length in shape])
        if array.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape, strict=True)):
            self.refuse(key, f"shape {array.shape} where {shape} is needed")
        if not np.isfinite(array).all():
            self.refuse(key, "a number is not finite")
        return array

    def refuse(self, key: str, reason: str) -> NoReturn:
        """Raise `ValueError` with the sentence about a key.

        Parameters
        ----------
        key, reason : str
        """
        raise ValueError(f"{self._prefix}{key}: {reason}")


def _short_number(digits: str) -> int:
    if len(digits) > LONGEST_NUMBER:
        raise ValueError(f"not a file of ours: a number has {len(digits)} digits")
    return int(digits)


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"not well-formed JSON: {name} is no number")
