"""Options of commands, for the rooms that have options of their own: the error of a wrong one, the choice of a name."""

import difflib
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
