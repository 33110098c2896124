"""The map of the dissertation: every item of it is named, and whatever the map names exists."""

import importlib
import re
import shlex
from itertools import pairwise
from pathlib import Path

import pytest

from appliance.cli.main import COMMANDS, parser

MAP = Path(__file__).parents[2] / "docs" / "reproduce.md"
ROWS = [
    [cell.strip() for cell in line.strip("|").split(" | ")]
    for line in MAP.read_text(encoding="utf-8").splitlines()
    if line.startswith("| ") and not line.startswith(("| item", "| ---", "| named"))
]
ITEMS = [row for row in ROWS if len(row) == 4]
WANTED = {
    "alg": [str(number) for number in range(1, 18)],
    "eq": [
        f"{chapter}.{number}"
        for chapter, last in ((2, 28), (3, 19), (4, 4), (5, 9), (6, 6))
        for number in range(1, last + 1)
    ],
    "table": ["3.1", "3.2", "3.3", "4.1", "5.1", "6.1", "6.2", "6.3"],
    "fig": [
        f"{chapter}.{number}"
        for chapter, last in ((2, 13), (3, 29), (4, 9), (5, 13), (6, 22))
        for number in range(1, last + 1)
    ],
}


def named(cell: str, kind: str) -> list[str]:
    """Numbers of one kind in a cell such as `alg. 15, fig. 6.4, 6.6 to 6.8`."""
    found, now = [], ""
    for whole in re.split(r",\s*", cell):
        word = re.match(r"(alg|eq|table|fig)s?\.? ", whole)
        now, part = (word[1], whole[word.end() :]) if word else (now, whole)
        if now != kind:
            continue
        first, _, last = part.partition(" to ")
        found.append(first)
        while last and first != last:
            chapter, dot, number = first.rpartition(".")
            first = f"{chapter}{dot}{int(number) + 1}"
            found.append(first)
    return found


@pytest.mark.parametrize("kind", WANTED)
def test_every_item_of_the_dissertation_stands_in_the_map_once(kind):
    found = [number for row in ITEMS for number in named(row[0], kind)]
    assert sorted(found) == sorted(WANTED[kind])


@pytest.mark.parametrize("row", ITEMS, ids=lambda row: row[0])
def test_every_name_of_a_row_exists_where_the_map_says(row):
    for path, names in re.findall(r"`((?:vision|appliance)/[\w/]+)\.py` ([\w, ]+)", row[1]):
        module = importlib.import_module(path.replace("/", "."))
        for name in names.split(", "):
            assert hasattr(module, name.strip()), f"{path}: {name}"


@pytest.mark.parametrize("row", ITEMS, ids=lambda row: row[0])
def test_every_command_of_a_row_has_these_options(row):
    for line in re.findall(r"`hotgauge ([^`]+)`", row[2]):
        name, *words = shlex.split(line)
        assert name in COMMANDS
        options = parser()._subparsers._group_actions[0].choices[name]._option_string_actions
        for word in words:
            assert not word.startswith("--") or word in options, word
        choice = dict(pairwise(words))
        for option in ("--method", "--classifier", "--criterion"):
            choices = options[option].choices if option in options else None
            assert option not in choice or choices is None or choice[option] in choices


def test_a_row_without_code_says_why():
    assert all(row[3] != "-" for row in ITEMS if row[1] == "-")
