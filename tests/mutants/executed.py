"""Which tests execute which line: `python -m mutants.executed MAP FOLDER ...` runs tests and writes it down.

Each folder or file of tests is run by itself, and MAP is a folder with one file for each, so that several may be drawn
beside each other and those that stand there already are not drawn again.
"""

import argparse
import ast
import json
import re
import tempfile
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from coverage import CoverageData

from mutants.copies import copied, run_tests

SOURCES = ("vision", "plc", "appliance")
LONGEST_S = 3600.0
DEPTH = 2  # steps from a line that no test executes to those that name what it defines
SETTINGS = "[run]\nsource = appliance,plc,vision\nrelative_files = true\ndata_file = {}\n"


def draw(copy: Path, tests: str, output: Path) -> None:
    """Run tests in the copy and write which lines each executes, and its seconds; those that fail are left out."""
    with tempfile.TemporaryDirectory() as folder:
        data, settings = Path(folder) / "data", Path(folder) / "coverage.ini"
        settings.write_text(SETTINGS.format(data), encoding="utf-8")
        options = ("--cov", f"--cov-config={settings}", "--cov-context=test", "--cov-report=")
        seconds = run_tests(copy, [tests], LONGEST_S, options).seconds
        lines = _lines(data, seconds.keys())
    output.write_text(json.dumps({"seconds": dict(seconds), "lines": lines}), encoding="utf-8")


def _lines(data: Path, tests: Iterable[str]) -> dict[str, dict[int, list[str]]]:
    """Tests by file and line. A fixture's lines count for all tests of the file: one of them sets it up for many."""
    read = CoverageData(str(data))
    read.read()
    by_file: dict[str, list[str]] = {}
    for test in tests:
        by_file.setdefault(test.partition("::")[0], []).append(test)
    found: dict[str, dict[int, list[str]]] = {}
    for file in read.measured_files():
        for line, contexts in read.contexts_by_lineno(file).items():
            names = set[str]()
            for context in filter(None, contexts):
                test, _, part = context.rpartition("|")
                names |= {test} if part == "run" else set(by_file.get(test.partition("::")[0], ()))
            if kept := sorted(names & set(tests)):
                found.setdefault(file, {})[line] = kept
    return found


class Executed:
    """Tests by line, read from a folder that `draw` filled.

    Parameters
    ----------
    folder : Path
    copy : Path
        The repository.
    """

    def __init__(self, folder: Path, copy: Path) -> None:
        self.copy = copy
        self.seconds: dict[str, float] = {}
        self.lines: dict[str, dict[int, set[str]]] = {}
        self.files: set[str] = set()
        for file in sorted(folder.glob("*.json")):
            drawn = json.loads(file.read_text(encoding="utf-8"))
            self.seconds |= drawn["seconds"]
            self.files |= {test.partition("::")[0] for test in drawn["seconds"]}
            for source, lines in drawn["lines"].items():
                known = self.lines.setdefault(source, {})
                for line, tests in lines.items():
                    known.setdefault(int(line), set()).update(tests)

    def by(self, file: str, line: int) -> set[str]:
        """Tests that execute a line.

        Of a line that runs on import, or is compiled by numba and so unseen, those that execute a line which names
        what is defined there.
        """
        return self._by(file, line, DEPTH)

    def _by(self, file: str, line: int, depth: int) -> set[str]:
        known = self.lines.get(file, {})
        chain = [node for node in ast.walk(_tree(self.copy / file)) if _holds(node, line)]
        statement = max(
            (node for node in chain if isinstance(node, ast.stmt)), key=lambda node: node.lineno, default=None
        )
        if statement is None:
            return set()
        tests = known.get(line) or known.get(statement.lineno)
        if tests and not self.runs_on_import(file, line):
            return tests
        own = range(statement.lineno, (statement.end_lineno or 0) + 1)
        places = [
            place
            for name in _defined(chain)
            for place in self._mentions(name)
            if place[0] != file or place[1] not in own
        ]
        found = set[str]().union(*(self.lines.get(source, {}).get(number, ()) for source, number in places))
        if found or not depth:
            return found
        return found.union(*(self._by(source, number, depth - 1) for source, number in places))

    def runs_on_import(self, file: str, line: int) -> bool:
        """Whether a line is in no function's body: the first test that imports its file would seem its only one."""
        nodes = (node for node in ast.walk(_tree(self.copy / file)) if _holds(node, line))
        functions = (node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))
        return not any(node.body[0].lineno <= line for node in functions)

    def _mentions(self, name: str) -> Iterable[tuple[str, int]]:
        pattern = re.compile(rf"\b{re.escape(name)}\b")
        for room in SOURCES:
            for path in sorted((self.copy / room).rglob("*.py")):
                text = _text(path)
                if name in text:
                    numbers = (number for number, row in enumerate(text.splitlines(), 1) if pattern.search(row))
                    yield from ((str(path.relative_to(self.copy)), number) for number in numbers)


def _holds(node: ast.AST, line: int) -> bool:
    first, last = getattr(node, "lineno", 0), getattr(node, "end_lineno", 0)
    return first <= line <= last


def _defined(chain: list[ast.AST]) -> set[str]:
    """What a line defines: its function, or the names that it gives a value."""
    functions = [node for node in chain if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    if functions:
        return {max(functions, key=lambda node: node.lineno).name}
    found = set[str]()
    for node in chain:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        found |= {part.id for one in targets if one for part in ast.walk(one) if isinstance(part, ast.Name)}
    return found or {node.name for node in chain if isinstance(node, ast.ClassDef)}


@cache
def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(_text(path))


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m mutants.executed", description=__doc__)
    parser.add_argument("map", type=Path)
    parser.add_argument("tests", nargs="+", help="folders or files of tests")
    given = parser.parse_args()
    given.map.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        copy = copied(Path(folder))
        for tests in given.tests:
            output = given.map / f"{tests.strip('/').replace('/', '.')}.json"
            if not output.exists():
                draw(copy, tests, output)
                print(f"{tests}: {output}", flush=True)


if __name__ == "__main__":
    main()
