"""Runs studies and writes their results: `python -m studies [NAME ...]`, all of them without a name."""

import argparse
import json
import subprocess
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from pathlib import Path

from tqdm import tqdm

FOLDER = Path(__file__).parent
RESULTS = FOLDER.parents[1] / "docs" / "studies"
CHUNK = 11  # cases that one process takes at once: conditions of one seed share what is slow to draw
NAMES = tuple(sorted(path.stem for path in FOLDER.glob("[a-z]*.py") if not path.stem.startswith("test_")))


def study(name):
    return import_module(f"studies.{name}")


def row(name, case):
    return case | study(name).run(case)


def commit():
    def git(*words):
        return subprocess.run(["git", *words], cwd=FOLDER, capture_output=True, text=True, check=True).stdout.strip()

    return git("rev-parse", "HEAD") + ("+" if git("status", "--porcelain", "--", "vision", "appliance", "plc") else "")


def key(case):
    return json.dumps(case, sort_keys=True)


def _kept(name, cases):
    """Rows of the written result whose cases are still those of the study, and at which commits they were drawn."""
    written = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    known = {key(case) for case in cases}
    found = {key({part: one[part] for part in cases[0]}): one for one in written["rows"]}
    kept = {case: one for case, one in found.items() if case in known}
    return {"earlier": [*written.get("earlier", []), {"commit": written["commit"], "cases": len(kept)}]}, kept


def write(name, processes, *, append=False):
    cases = study(name).cases()
    made_from = commit()
    earlier, kept = _kept(name, cases) if append else ({}, {})
    new = [case for case in cases if key(case) not in kept]
    with ProcessPoolExecutor(processes) as pool:
        chunk = getattr(study(name), "CHUNK", CHUNK)
        found = pool.map(row, [name] * len(new), new, chunksize=chunk)
        drawn = {
            key(case): one for case, one in zip(new, tqdm(found, total=len(new), desc=name, disable=None), strict=True)
        }
    rows = [(kept | drawn)[key(case)] for case in cases]
    head = {"study": name, "text": study(name).TEXT, "commit": made_from, "cases": len(rows)} | earlier
    lines = ",\n".join(f"  {json.dumps(one)}" for one in rows)
    summary = json.dumps(study(name).summary(rows), indent=1)
    text = f'{json.dumps(head)[:-1]},\n"summary": {summary},\n"rows": [\n{lines}\n]}}\n'
    json.loads(text)
    RESULTS.mkdir(parents=True, exist_ok=True)
    (RESULTS / f"{name}.json").write_text(text, encoding="utf-8")
    print(f"{name}: {len(rows)} cases\n{summary}")


def main():
    parser = argparse.ArgumentParser(prog="python -m studies", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(NAMES)}")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--append", action="store_true", help="keep the rows that are written, draw the new cases")
    given = parser.parse_args()
    for name in given.names or NAMES:
        if name not in NAMES:
            parser.error(f"there is no study {name}; there are {', '.join(NAMES)}")
        write(name, given.processes, append=given.append)


if __name__ == "__main__":
    main()
