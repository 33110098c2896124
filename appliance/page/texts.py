"""The one table of the page's texts, in English and German, and how texts are found in it."""

import functools
import importlib.resources
import tomllib
from typing import Literal

from appliance.diagnostics.alarms import ALARMS
from appliance.diagnostics.fault_table import FAULTS
from plc.codes import CODES, NamedBit

Language = Literal["en", "de"]
LANGUAGES: tuple[Language, ...] = ("en", "de")


@functools.cache
def table() -> dict[str, dict[str, list[str]]]:
    """Sections of the table: `page` has English and German; the others German of what other tables say in English."""
    file = importlib.resources.files("appliance.page").joinpath("texts.toml")
    return tomllib.loads(file.read_text(encoding="utf-8"))


class Texts:
    """Texts in one language.

    Parameters
    ----------
    language : {"en", "de"}

    Attributes
    ----------
    language : {"en", "de"}
    decimal : str
        Decimal sign.
    """

    def __init__(self, language: Language) -> None:
        self.language: Language = language
        self._column = LANGUAGES.index(language)
        self.decimal = "," if language == "de" else "."

    def __call__(self, key: str, **values: object) -> str:
        """Text of the page, with values in its braces; raises `KeyError` for a key that the table lacks."""
        return table()["page"][key][self._column].format(**values)

    def alarm(self, name: str) -> tuple[str, str]:
        """What an alarm says, and what to do about it."""
        return self._pair("alarms", name, _ALARMS[name])

    def fault(self, name: str) -> tuple[str, str]:
        """What a fault says, and what to do about it."""
        return self._pair("faults", name, _FAULTS[name])

    def reason(self, named: NamedBit) -> str:
        """What a reason flag says."""
        return self._pair("reasons", named.name, (named.text, ""))[0]

    def code(self, register: str, number: float | None) -> str:
        """Words of a register's code."""
        if number is None:
            return self("no_value")
        words = CODES[register].texts().get(int(number), "?")
        return table()["codes"].get(words, [words])[0] if self.language == "de" else words

    def number(self, value: float | None, digits: int = 2, *, signed: bool = False) -> str:
        """A number with the language's decimal sign; a dash for no value.

        Parameters
        ----------
        value : float or None
        digits : int
            Behind the decimal sign.
        signed : bool
            Whether a positive number has its sign.
        """
        if value is None:
            return "–"
        text = f"{value:{'+' if signed else ''}.{digits}f}".replace("-", "−")
        return text.replace(".", self.decimal)

    def _pair(self, section: str, name: str, english: tuple[str, str]) -> tuple[str, str]:
        if self.language == "en":
            return english
        german = table()[section].get(name, list(english))
        return german[0], german[-1]


_ALARMS = {row.name: (row.text, row.remedy) for row in ALARMS}
_FAULTS = {row.name: (row.text, row.remedy) for row in FAULTS}
