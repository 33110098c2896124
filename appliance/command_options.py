"""Options of commands, for the rooms that have options of their own: what is wrong with one, names, numbers."""

import argparse
import difflib
import math
from collections.abc import Sequence
from typing import TypeVar

from appliance.errors import HotgaugeError

NameT = TypeVar("NameT", bound=str)


class CommandError(HotgaugeError):
    """The command cannot do what it was asked for; the message says what, where and what to do."""


def one_of(known: Sequence[NameT], name: str, option: str) -> NameT:
    """The known name that was given.

    Parameters
    ----------
    known : sequence of str
    name : str
        As given on the command line.
    option : str
        With its dashes, for the sentence that refuses.

    Raises
    ------
    CommandError
        The name is not known; the sentence offers the nearest, or all.
    """
    for one in known:
        if name == one:
            return one
    near = difflib.get_close_matches(name, known, n=1)
    advice = f"did you mean {near[0]}?" if near else "there are " + ", ".join(known)
    raise CommandError(f"{option}: there is no {name}; {advice}")


def number_within(text: str, least: float, most: float, unit: str) -> float:
    """Number of an option.

    Parameters
    ----------
    text : str
    least, most : float
        Bounds.
    unit : str
        Plural, for the sentence that refuses.

    Raises
    ------
    ArgumentTypeError
        The text is no number, or out of bounds.
    """
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not least <= number <= most:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of {unit} from {least:g} to {most:g}")
    return number
