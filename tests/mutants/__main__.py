"""Draws mutants and runs the tests that execute their lines: `python -m mutants FOLDER --map MAP --count N --seed S`.

Works in a copy of the repository; MAP is written by `python -m mutants.executed`. Prints one line for each mutant; the
outcomes are written as JSON lines. Those that survive are judged by a person: a gap in the tests, or code that says the
same.
"""

import argparse
import ast
import collections
import json
import os
import tempfile
import time
from functools import cache
from pathlib import Path

from mutants.copies import copied, run_tests
from mutants.drawn import Mutant, drawn
from mutants.executed import Executed

NEAR = 15  # tests that are run first: most mutants end there
MOST = 60  # tests for one mutant
MOST_SECONDS = 25.0  # of all its tests together, where no mutant is in their way
PATIENCE = 8.0  # times as long may they take, on a computer that does other things too
START_S = 120.0


def chosen(executed: Executed, mutant: Mutant, *, all_of_them: bool = False) -> list[str]:
    """Tests for a mutant: of files that import its module first, then of its room; bounded in number and seconds.

    Of a line that runs on import, all tests of files that import its module are among them.
    """
    tests = executed.by(mutant.file, mutant.line)
    module = mutant.file.removesuffix(".py").replace("/", ".")
    importing = {file for file in executed.files if _imports(executed.copy / file, module)}
    if executed.runs_on_import(mutant.file, mutant.line) or not tests:
        tests = tests | {test for test in executed.seconds if test.partition("::")[0] in importing}
    room = mutant.file.partition("/")[0]

    def distance(test: str) -> tuple[bool, bool, float]:
        file = test.partition("::")[0]
        return file not in importing, room not in file.split("/"), executed.seconds[test]

    found, total_s = list[str](), 0.0
    for test in sorted(tests, key=distance):
        total_s += executed.seconds[test]
        if found and not all_of_them and (total_s > MOST_SECONDS or len(found) == MOST):
            break
        found.append(test)
    return found


@cache
def _imports(file: Path, module: str) -> bool:
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module in {module, module.rpartition(".")[0]}:
            names = {f"{node.module}.{one.name}" for one in node.names}
            if node.module == module or module in names:
                return True
    return False


def outcome(executed: Executed, mutant: Mutant, *, all_of_them: bool = False) -> tuple[str, str, int]:
    """`killed`, `survived`, `no test` or `unclear`, by which test, of how many."""
    tests = chosen(executed, mutant, all_of_them=all_of_them)
    file = executed.copy / mutant.file
    kept, times = file.read_text(encoding="utf-8"), file.stat()
    anew = mutant.file.startswith("vision") and ("njit" in kept or not _is_indented(kept, mutant.line))
    file.write_text(mutant.source, encoding="utf-8")
    try:
        for batch in filter(None, (tests[:NEAR], tests[NEAR:])):
            limit_s = START_S * (3 if anew else 1) + PATIENCE * sum(executed.seconds[test] for test in batch)
            ending = run_tests(executed.copy, batch, limit_s, compile_anew=anew)
            if ending.code != 0:
                killed = ending.failed or ending.code is None or ending.code < 0  # a test, the limit, or a crash
                return ("killed" if killed else "unclear"), ending.failed, len(tests)
    finally:
        file.write_text(kept, encoding="utf-8")
        os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))  # numba compiles anew what looks younger
    return ("survived" if tests else "no test"), "", len(tests)


def _is_indented(text: str, line: int) -> bool:
    return text.splitlines()[line - 1].startswith(" ")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m mutants", description=__doc__)
    parser.add_argument("folder", help="vision, plc or appliance, or a folder below")
    parser.add_argument("--map", type=Path, required=True, help="folder that `python -m mutants.executed` has filled")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--for", type=float, default=1e9, dest="seconds", help="no new mutant after so many seconds")
    parser.add_argument("--output", type=Path, required=True, help="JSON lines of outcomes; what is there is continued")
    parser.add_argument("--again", action="store_true", help="show what survived to all tests that execute its line")
    given = parser.parse_args()
    begun_s = time.monotonic()
    rows = [json.loads(line) for line in given.output.read_text().splitlines()] if given.output.exists() else []
    with tempfile.TemporaryDirectory() as folder:
        copy = copied(Path(folder))
        executed = Executed(given.map, copy)
        mutants = drawn(copy, given.folder, given.count, given.seed)
        left = [place for place in range(len(mutants)) if place >= len(rows)]
        if given.again:
            left = [place for place, row in enumerate(rows) if row["outcome"] != "killed"]
        for place in left:
            if time.monotonic() - begun_s > given.seconds:
                break
            mutant = mutants[place]
            found, by, tests = outcome(executed, mutant, all_of_them=given.again)
            row = mutant._asdict() | {"outcome": found, "by": by, "tests": tests}
            del row["source"]
            print(f"{found:9}{mutant.file}:{mutant.line}: {mutant.before} -> {mutant.after}", flush=True)
            rows[place : place + 1] = [row]
            given.output.write_text("".join(json.dumps(one) + "\n" for one in rows), encoding="utf-8")
    print(dict(collections.Counter(row["outcome"] for row in rows)))


if __name__ == "__main__":
    main()
