"""Outcomes of mutants as a result file: `python -m mutants.result LINES ...` writes docs/studies/mutants.json.

Verdicts on survivors are a person's, written into that file, and stay when it is written again.
"""

import argparse
import json
import subprocess
from pathlib import Path

RESULT = Path(__file__).parents[2] / "docs" / "studies" / "mutants.json"
TEXT = (
    "Small changes of the source, one at a time, every place in the code of a folder with the same chance; only tests "
    "that execute the changed line are run. `killed` is noticed by a test. Of the others the verdict says why: "
    "`equivalent`, code that says the same, left out of the shares; `closed`, a gap that a test closes since; `open`. "
    "Survivors that a test outside of the map notices (documents, OpenCV's forest) were shown to it and are killed. "
    "The last 60 of vision were shown to their 15 nearest tests and, if they survived, to others by name; ten of the "
    "last 52 of appliance only to today's tests. Every closed one was shown to its test on today's code."
)
PLACE = ("file", "line", "before", "after")


def place(row: dict) -> tuple:
    """What one mutant is known by."""
    return tuple(row[name] for name in PLACE)


def summary(rows: list[dict]) -> dict[str, dict]:
    """Counts for each folder, and the share that was killed when it was drawn and that is killed now."""
    found = {}
    for folder in sorted({row["file"].partition("/")[0] for row in rows}):
        own = [row for row in rows if row["file"].startswith(f"{folder}/")]
        killed = sum(row["outcome"] == "killed" for row in own)
        verdicts = [row.get("verdict", "open").partition(":")[0] for row in own if row["outcome"] != "killed"]
        counts = {name: verdicts.count(name) for name in ("equivalent", "closed", "open")}
        of = len(own) - counts["equivalent"]
        shares = {"killed_share": round(killed / of, 4), "killed_share_now": round((killed + counts["closed"]) / of, 4)}
        found[folder] = {"drawn": len(own), "killed": killed, **counts, **shares}
    return found


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m mutants.result", description=__doc__)
    parser.add_argument("lines", nargs="*", type=Path, help="outputs of `python -m mutants`; none: count anew")
    parser.add_argument("--seed", type=int, help="that they were drawn with")
    parser.add_argument("--commit", help="of the code that they are changes of; without: the one that is checked out")
    given = parser.parse_args()
    before = json.loads(RESULT.read_text(encoding="utf-8")) if RESULT.exists() else {"rows": []}
    verdicts = {place(row): row["verdict"] for row in before["rows"] if "verdict" in row}
    lines = [line for file in given.lines for line in file.read_text(encoding="utf-8").splitlines()]
    rows = [json.loads(line) for line in lines] or before["rows"]
    rows = [({"verdict": verdicts[place(row)]} if place(row) in verdicts else {}) | row for row in rows]
    words = ["git", "rev-parse", given.commit or "HEAD"]
    now = subprocess.run(words, cwd=RESULT.parent, capture_output=True, text=True, check=True).stdout.strip()
    head = {"study": "mutants", "text": TEXT, "seed": given.seed, "commit": now, "cases": len(rows)}
    if not lines:
        head |= {name: before[name] for name in ("seed", "commit")}
    text = ",\n".join(f"  {json.dumps(row)}" for row in rows)
    counts = json.dumps(summary(rows), indent=1)
    RESULT.write_text(f'{json.dumps(head)[:-1]},\n"summary": {counts},\n"rows": [\n{text}\n]}}\n', encoding="utf-8")
    print(counts)


if __name__ == "__main__":
    main()
