"""Draws mutants and runs the tests that concern their modules: `python -m mutants FOLDER --count N --seed S`.

`python -m mutants --audit` runs those of `audit.toml` instead, one for each step of the dissertation, and writes
`audit.md`.
Works in a copy of the repository. Prints one line for each mutant; those that survive are written as JSON lines, to be
judged by a person: a gap in the tests, or code that says the same.
"""

import argparse
import ast
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from mutants import audit
from mutants.drawn import Mutant, drawn

ROOT = Path(__file__).parents[2]
LONGEST_S = 300.0
FILES_MOST = 8  # of tests for one mutant, unless given
NOT_COPIED = shutil.ignore_patterns(".git", ".venv*", ".pytest_cache")
ROOMS_OF_TESTS = ("tests/unit", "tests/system/modbus", "tests/accuracy")


def imports_of(file: Path) -> set[str]:
    """Modules that a file of tests names."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {one.name for one in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{one.name}" for one in node.names)}
    return found


def concerning(root: Path, module: str, most: int) -> list[str]:
    """Files of tests for a module: those that import it, then those that import what imports it, nearest first."""
    names = {
        _module(file, root): file for part in ("vision", "plc", "appliance") for file in (root / part).rglob("*.py")
    }
    users = {name: imports_of(file) & names.keys() for name, file in names.items()}
    tests = {file: imports_of(file) for room in ROOMS_OF_TESTS for file in sorted((root / room).rglob("test_*.py"))}
    kit = {file.stem: imports_of(file) & names.keys() for file in (root / "tests" / "kit").rglob("*.py")}
    reached, found = {module}, dict[Path, None]()
    while reached and len(found) < most:
        helpers = {name for name, used in kit.items() if used & reached}
        near = [file for file, used in tests.items() if used & (reached | helpers)]
        unit_first = sorted(near, key=lambda file: _room(file.relative_to(root)))
        found |= dict.fromkeys(unit_first)
        before = reached
        reached = reached | {name for name, used in users.items() if used & reached}
        if reached == before:
            break
    return [str(file.relative_to(root)) for file in list(found)[:most]]


def _room(file: Path) -> int:
    return next(place for place, room in enumerate(ROOMS_OF_TESTS) if file.is_relative_to(room))


def _module(file: Path, root: Path) -> str:
    return ".".join(file.relative_to(root).with_suffix("").parts).removesuffix(".__init__")


def outcome(copy: Path, mutant: Mutant, tests: list[str], too_long: str = "killed") -> str:
    """`killed`, `survived`, `no test`, or what is said of tests that do not end in time."""
    if not tests:
        return "no test"
    file = copy / mutant.file
    kept, times = file.read_text(encoding="utf-8"), file.stat()
    file.write_text(mutant.source, encoding="utf-8")
    words = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(words, cwd=copy, env=environment, capture_output=True, timeout=LONGEST_S, check=False)
    except subprocess.TimeoutExpired:
        return too_long
    finally:
        file.write_text(kept, encoding="utf-8")
        os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))  # numba compiles anew what looks younger
    return "survived" if done.returncode == 0 else "killed"


def run_audit() -> None:
    """Outcomes of the mutants by name, written to `audit.md`; without a mutant all of their tests pass."""
    rows: list[tuple[audit.Named, str]] = []
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "copy"
        shutil.copytree(ROOT, copy, ignore=NOT_COPIED)
        passing: set[tuple[str, ...]] = set()
        for one in audit.named(copy):
            unchanged = one.mutant._replace(source=(copy / one.mutant.file).read_text(encoding="utf-8"))
            if one.tests not in passing and outcome(copy, unchanged, [*one.tests], "too long") != "survived":
                raise SystemExit(f"{', '.join(one.tests)}: fail without a mutant")
            passing.add(one.tests)
            found = outcome(copy, one.mutant, [*one.tests], "too long")
            rows.append((one, found))
            print(f"{found:9}{one.item}: {one.change}", flush=True)
    audit.FILE.with_suffix(".md").write_text(audit.table(rows), encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m mutants", description=__doc__)
    parser.add_argument("folder", nargs="?", default="vision", help="vision, plc or appliance, or a folder below")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--files", type=int, default=FILES_MOST, help="most files of tests for one mutant")
    parser.add_argument("--for", type=float, default=1e9, dest="seconds", help="no new mutant after so many seconds")
    parser.add_argument("--audit", action="store_true", help="the mutants by name in place of drawn ones")
    parser.add_argument("--output", type=Path, help="JSON lines of all outcomes; what is there is continued")
    given = parser.parse_args()
    if given.audit:
        run_audit()
        return
    begun_s = time.monotonic()
    counts: dict[str, int] = {}
    done = 0 if given.output is None or not given.output.exists() else len(given.output.read_text().splitlines())
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "copy"
        shutil.copytree(ROOT, copy, ignore=NOT_COPIED)
        for mutant in drawn(copy, given.folder, given.count, given.seed)[done:]:
            if time.monotonic() - begun_s > given.seconds:
                break
            tests = concerning(copy, _module(copy / mutant.file, copy), given.files)
            found = outcome(copy, mutant, tests)
            counts[found] = counts.get(found, 0) + 1
            row = mutant._asdict() | {"outcome": found, "tests": tests}
            del row["source"]
            print(f"{found:9}{mutant.file}:{mutant.line}: {mutant.before} -> {mutant.after}", flush=True)
            if given.output is not None:
                with given.output.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
    print(counts)


if __name__ == "__main__":
    main()
