"""Mutants by name, of `audit.toml`: one for each constant and step of the dissertation that a test must hold.

`python -m mutants.audit` makes them, one at a time and in a copy of the repository, and writes `audit.md`.
"""

import os
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from mutants.copies import copied, run_tests
from mutants.drawn import Mutant

FILE = Path(__file__).with_name("audit.toml")
LONGEST_S = 300.0  # of one mutant's tests


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
        f"{killed} of {len(rows)} make a test fail (`python -m mutants.audit`). `audit.toml` has what replaces what.",
        "",
        "| item | changed | file | outcome |",
        "| --- | --- | --- | --- |",
        *(f"| {one.item} | {one.change} | `{one.mutant.file}` | {outcome} |" for one, outcome in rows),
    ]
    return "\n".join(lines) + "\n"


def outcome(copy: Path, one: Named, source: str) -> str:
    """`killed`, `survived` or `unclear`, where the tests did not end in time."""
    file = copy / one.mutant.file
    kept, times = file.read_text(encoding="utf-8"), file.stat()
    file.write_text(source, encoding="utf-8")
    try:
        ending = run_tests(copy, one.tests, LONGEST_S, compile_anew="njit" in kept)
    finally:
        file.write_text(kept, encoding="utf-8")
        os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))  # numba compiles anew what looks younger
    if ending.code == 0:
        return "survived"
    return "killed" if ending.failed else "unclear"


def main() -> None:
    """Make every mutant; without one, all of its tests must pass."""
    rows: list[tuple[Named, str]] = []
    passing: set[tuple[str, ...]] = set()
    with tempfile.TemporaryDirectory() as folder:
        copy = copied(Path(folder))
        for one in named(copy):
            if (
                one.tests not in passing
                and outcome(copy, one, (copy / one.mutant.file).read_text("utf-8")) != "survived"
            ):
                raise SystemExit(f"{', '.join(one.tests)}: fail without a mutant")
            passing.add(one.tests)
            rows.append((one, outcome(copy, one, one.mutant.source)))
            print(f"{rows[-1][1]:9}{one.item}: {one.change}", flush=True)
    FILE.with_suffix(".md").write_text(table(rows), encoding="utf-8")


if __name__ == "__main__":
    main()
