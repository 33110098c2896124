"""What an experiment of the report consists of: cases that run apart, and the section that their results make."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, NamedTuple

Case = dict[str, Any]
Result = dict[str, Any]


class Table(NamedTuple):
    """A table of the report.

    Attributes
    ----------
    title : str
    columns : tuple of str
        The first heads the names of the rows.
    rows : list of tuple of str
        "-" where there is nothing to say.
    note : str
        Why; needed where a row has a "-".
    """

    title: str
    columns: tuple[str, ...]
    rows: list[tuple[str, ...]]
    note: str = ""


class Plot(NamedTuple):
    """A figure of the report.

    Attributes
    ----------
    name : str
        Of its file, without a suffix.
    title : str
    draw : callable
        Draws on the axes that it is given.
    """

    name: str
    title: str
    draw: Callable[[Any], None]


class Section(NamedTuple):
    """What the report says of an experiment.

    Attributes
    ----------
    title, conditions : str
    tables : list of Table
    plots : list of Plot
    findings : list of str
        A sentence on each difference from what the dissertation says.
    """

    title: str
    conditions: str
    tables: list[Table]
    plots: list[Plot]
    findings: list[str]


class Experiment(ABC):
    """One experiment.

    Attributes
    ----------
    name : str
        Of its file of results.
    """

    name: ClassVar[str]

    @abstractmethod
    def cases(self, *, quick: bool) -> list[Case]:
        """What is to be run, each on its own; a case and its result can be written as JSON."""

    @abstractmethod
    def run(self, case: Case) -> Result:
        """Run a case; the same case gives the same result, times excepted."""

    @abstractmethod
    def section(self, results: Sequence[tuple[Case, Result]]) -> Section:
        """Section of all cases with their results."""


def number(value: float | None, form: str = ".3f") -> str:
    """A figure of a table, "-" where there is none.

    Parameters
    ----------
    value : float or None
    form : str
        Of `format`.
    """
    return "-" if value is None or value != value else format(value, form)  # noqa: PLR0124  NaN alone differs from itself
