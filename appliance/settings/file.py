"""Reads the settings file, TOML, and says in one sentence what is wrong with it.

The appliance runs without a file, with the defaults. Unknown keys are refused.
"""

import difflib
import re
import tomllib
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from appliance.errors import HotgaugeError, reading_advice
from appliance.settings.masking import mask
from appliance.settings.table import Kind, SettingRow, as_toml, table


class SettingsError(HotgaugeError):
    """The settings file cannot be used; the message names file, key, what is wrong and what is allowed."""


_COMMA = re.compile(r"=[ \t]*(-?\d+),(\d+)")  # of a number as Germans write it

RootT = TypeVar("RootT", bound=BaseModel)


def _values(text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        if decimal := _COMMA.search(text):
            raise ValueError(f"{error}; decimals have a point: {decimal[1]}.{decimal[2]}") from error
        raise


def load(path: Path | None, root: type[RootT]) -> RootT:
    """Read and check a settings file.

    Parameters
    ----------
    path : Path or None
        TOML file; None gives the defaults.
    root : type
        Type of the whole file's settings.

    Returns
    -------
    Instance of `root`

    Raises
    ------
    SettingsError
        File missing or unreadable, TOML not well-formed, key unknown, value of a wrong type or out of bounds.
    """
    if path is None:
        return root()
    try:
        text = path.read_text(encoding="utf-8-sig")
        values = _values(text)
        return root.model_validate(values, context={"folder": path.parent})
    except OSError as error:
        raise SettingsError(
            f"{path}: {error.strerror}; {reading_advice(error, 'give an existing TOML file')}"
        ) from error
    except UnicodeDecodeError as error:
        raise SettingsError(f"{path}: not a text in UTF-8; save it in that encoding") from error
    except ValidationError as error:
        raise SettingsError(
            f"{path}: " + "; ".join(mask(_sentence(detail, root)) for detail in error.errors())
        ) from None
    except (ValueError, RecursionError) as error:  # also of a number of thousands of digits, which is none of ours
        raise SettingsError(f"{path}: not well-formed TOML: {error}") from error


def _sentence(detail: ErrorDetails, root: type[BaseModel]) -> str:
    rows = table(root)
    key, kinds = _place(detail["loc"], rows)
    if detail["type"] == "extra_forbidden":
        return f"{key}: unknown key; {_nearest(key, kinds, rows)}"
    if detail["type"] == "value_error":  # of a check of our own, whose text says what to do
        return f"{key}: {detail.get('ctx', {}).get('error', detail['msg'])}"
    given = detail["input"]
    if detail["type"].startswith("union_tag"):
        context = detail.get("ctx", {})
        key, given = f"{key}.{context['discriminator'].strip(chr(39))}", context.get("tag")
    here = [row for row in rows if row.key == key and not _elsewhere(row, kinds)]
    allowed = " or ".join(dict.fromkeys(row.allowed for row in here)) or "a [section]"
    missing = detail["type"] in {"missing", "union_tag_not_found"}
    return f"{key}: missing; give {allowed}" if missing else f"{key} = {as_toml(given)} is not allowed; give {allowed}"


def _place(location: tuple[int | str, ...], rows: tuple[SettingRow, ...]) -> tuple[str, tuple[Kind, ...]]:
    """Dotted key of an error, and the kinds of the sections that hold it, outermost first."""
    choosing = {kind.key.rpartition(".")[0]: kind.key for row in rows for kind in row.kinds}
    key, kinds, chosen = "", list[Kind](), False
    for part in (part for part in location if isinstance(part, str)):  # not the places in a list
        chosen = key in choosing and not chosen
        if chosen:
            kinds.append(Kind(choosing[key], part))
        else:
            key = f"{key}.{part}" if key else part
    return key, tuple(kinds)


def _elsewhere(row: SettingRow, kinds: tuple[Kind, ...]) -> list[Kind]:
    """Kinds that a row needs and that the file sets otherwise."""
    there = dict(kinds)
    return [kind for kind in row.kinds if there.get(kind.key, kind.choice) != kind.choice]


def _alike(key: str, section: str, keys: list[str]) -> str:
    """Known key spelt most like this one: of its own section, else of another; empty for none."""
    here = {other.removeprefix(f"{section}."): other for other in keys if other.rpartition(".")[0] == section}
    near = difflib.get_close_matches(key.rpartition(".")[2], here, n=1, cutoff=0.75)
    if near:
        return here[near[0]]
    names = {other.rpartition(".")[2]: other for other in keys}
    same = difflib.get_close_matches(key.rpartition(".")[2], names, n=1, cutoff=0.75)
    return names[same[0]] if same else next(iter(difflib.get_close_matches(key, keys, n=1, cutoff=0.85)), "")


def _nearest(key: str, kinds: tuple[Kind, ...], rows: tuple[SettingRow, ...]) -> str:
    section = key.rpartition(".")[0]
    wanted = [_elsewhere(row, kinds) for row in rows if row.key == key or row.key.startswith(f"{key}.")]
    if wanted:
        return f"it needs {' and '.join(map(str, min(wanted, key=len)))}; leave it out"
    keys = sorted({row.key for row in rows})
    near = _alike(key, section, keys)
    if near:
        return f"did you mean {near}?"
    sections = dict.fromkeys(other.partition(".")[0] for other in (row.key for row in rows))
    here = [other for other in keys if other.startswith(f"{section}.")] or [f"[{name}]" for name in sections]
    return "known here: " + ", ".join(here)
