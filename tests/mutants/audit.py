"""Mutants by name, of `audit.toml`: one for each constant and step of the dissertation that a test must hold."""

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from mutants.drawn import Mutant

FILE = Path(__file__).with_name("audit.toml")


class Named(NamedTuple):
    """One mutant.

    Attributes
    ----------
    item : str
        Of the dissertation.
    change : str
        In words.
    mutant : Mutant
    tests : tuple of str
        Files of tests, one of which must fail on it.
    """

    item: str
    change: str
    mutant: Mutant
    tests: tuple[str, ...]


def named(root: Path) -> Iterator[Named]:
    """All of them; raises `ValueError` where a text does not stand once in its file."""
    for place in tomllib.loads(FILE.read_text(encoding="utf-8"))["place"]:
        source = (root / place["file"]).read_text(encoding="utf-8")
        for item, change, before, after in place["mutants"]:
            if source.count(before) != 1:
                raise ValueError(f"{place['file']}: {before!r} stands {source.count(before)} times")
            line = source[: source.index(before)].count("\n") + 1
            mutant = Mutant(place["file"], line, before, after, source.replace(before, after))
            yield Named(item, change, mutant, tuple(place["tests"]))


def table(rows: list[tuple[Named, str]]) -> str:
    """Outcomes as Markdown."""
    killed = sum(outcome == "killed" for _, outcome in rows)
    lines = [
        "# Mutants of the dissertation's steps and constants",
        "",
        f"{killed} of {len(rows)} make a test fail (`python -m mutants --audit`). `audit.toml` has what replaces what.",
        "",
        "| item | changed | file | outcome |",
        "| --- | --- | --- | --- |",
        *(f"| {one.item} | {one.change} | `{one.mutant.file}` | {outcome} |" for one, outcome in rows),
    ]
    return "\n".join(lines) + "\n"
