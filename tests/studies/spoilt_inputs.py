"""Files and command lines as they should not be, at random: what the commands make of them."""

import csv
import io
import tempfile
from pathlib import Path

from spoilt import spoilt_bytes, spoilt_json, spoilt_text, spoilt_words
from tried_command import tried
from workshop import SCENE, chance_of, copied, true_diameter_mm, workshop

from appliance.conformity.plc_inputs import PlcInputsError, read
from appliance.history.database import FILE_NAME
from vision.edges.forest.model import StructuredForest, shipped_forest

TEXT = (
    "Every file that a person hands over (rig, board, regions, settings, measurements of a gauge study, time stamps, "
    "coding, PNG, JPEG, MP4, references, a model of edges, kept set points, readings, truth, "
    "history) and every command line, spoilt at random: "
    "bytes changed, cut, doubled and lost, values of other types and sizes, words left out, exchanged and added. "
    "`done` is exit 0 with a right result, `refused` exit 2 with one sentence; else there is a problem: a traceback, "
    "more than 20 s, more than 2 GB, a changed input, an output left behind by a refusal, a value off by more than "
    "2 U and 1 mm."
)
SAMPLE = 40
MEASURE = ("measure", SCENE, "--rig", "rig.json", "--output", "out.csv")
JPEGS = ("measure", "jpegs", "--rig", "rig.json", "--output", "out.csv")
ORIENT = ("orient", "ends", "--references", "references", "--output", "out.jsonl")
COMPARE = ("compare", "readings.jsonl", SCENE, "--plot", "errors.png")
PERIOD = ("--from", "2026-11-28T21:00Z", "--to", "2026-11-29T02:00Z", "--config", "history.toml")
EXPORT = ("export", "--what", "readings", *PERIOD, "--output", "out.csv")
FILES = {
    "rig": ("rig.json", spoilt_json, MEASURE),
    "board": ("mill/board.json", spoilt_json, ("calibrate", "mill", "--output", "out.json")),
    "roi": ("references/roi.json", spoilt_json, ORIENT),
    "settings": ("gauge.toml", spoilt_text, ("check-config", "gauge.toml")),
    "gauge study": ("study.csv", spoilt_text, ("gauge-study", "study.csv")),
    "stamps": ("jpegs/timestamps.csv", spoilt_text, JPEGS),
    "coding": ("jpegs/coding.json", spoilt_json, JPEGS),
    "png": (f"{SCENE}/left/000000.png", spoilt_bytes, MEASURE),
    "jpeg": ("jpegs/right/000000.jpg", spoilt_bytes, JPEGS),
    "video": ("video/left.mp4", spoilt_bytes, ("measure", "video", "--rig", "rig.json", "--output", "out.csv")),
    "reference": ("references/top.png", spoilt_bytes, ORIENT),
    "end picture": ("ends/000001.png", spoilt_bytes, ORIENT),
    "readings": ("readings.jsonl", spoilt_text, COMPARE),
    "truth": (f"{SCENE}/truth.json", spoilt_json, COMPARE),
    "history": (f"history/{FILE_NAME}", spoilt_bytes, EXPORT),
}
"""What is spoilt, how, and the command that reads it."""
TRUE_TO_THE_BAR = {"stamps", "coding", "png", "jpeg", "video"}
COMMANDS = (
    MEASURE,
    (*JPEGS, "--config", "gauge.toml"),
    ("measure", "ends", "--method", "conveyor", "--barrier-mm", "500", "--output", "out.csv"),
    ("orient", "ends", "--references", "references", "--output", "out.csv", "--classifier", "dual"),
    ("fuse", f"{SCENE}/left/000000.png", f"{SCENE}/right/000000.png", "--rig", "rig.json", "--output", "out.png"),
    ("check-config", "gauge.toml"),
    ("registers", "--format", "csv", "--bom"),
    ("registers", "--format", "st", "--plc", "codesys"),
    ("gauge-study", "study.csv", "--tolerance", "2"),
    ("verify", SCENE, "--rig", "rig.json", "--diameter", "250", "--u", "0.1", "--output", "out.html"),
    ("export", "--what", "bars", "--from", "2024-01-01", "--to", "2024-02-01", "--output", "out.csv"),
    ("report", "--from", "2024-01-01", "--to", "2024-02-01", "--output", "out.html"),
    ("certificates", "--output", "keys", "--client", "hmi", "--role", "viewer"),
    ("poll", "127.0.0.1:1", "--count", "1"),
)
"""Right command lines; those that serve, train, install or draw for minutes are not among them."""
MORE_COMMANDS = (
    COMPARE,
    EXPORT,
    ("report", *PERIOD, "--output", "out.html", "--shift-hours", "4"),
    (*MEASURE[:-1], "out.jsonl", "--plot", "plots"),
    (*ORIENT[:-1], "out.csv", "--plot", "plots"),
    ("calibrate", SCENE, "--output", "out.json", "--squares", "8", "5", "--square-mm", "50", "--region", "-250", "250"),
    ("board", "--squares", "8x5", "--mm", "50", "--output", "board.pdf"),
    ("plan", "--sensor", "320x256", "--pixel-um", "20", "--focal-mm", "12", "--distance-m", "3", "--output", "a.png"),
    ("registers", "--format", "json"),
    ("check-config", "history.toml"),
)
COUNTS = {
    "rig": 120, "board": 40, "roi": 300, "settings": 800, "gauge study": 400, "stamps": 80, "coding": 80, "png": 120,
    "jpeg": 120, "video": 80, "reference": 300, "model": 60, "set points": 400, "words": 500,
    "end picture": 250, "readings": 300, "truth": 300, "history": 250,
    "more words": 500,
}  # fmt: skip
WORDS = {"words": COMMANDS, "more words": MORE_COMMANDS}


def cases():
    return [{"kind": kind, "seed": seed} for kind, count in COUNTS.items() for seed in range(count)]


def run(case):
    kind, chance = case["kind"], chance_of(case["kind"], case["seed"])
    if kind == "model":
        return {"outcome": _model(spoilt_bytes(chance, _forest()))}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "work"
        if kind == "set points":
            copied(folder, ["set_points.json"])
            return {"outcome": _set_points(folder / "set_points.json", chance)}
        if kind in WORDS:
            words = spoilt_words(chance, list(chance.choice(WORDS[kind])))
            copied(folder, [])
            return {"outcome": _outcome(words, folder, right=None)} | {"words": words}
        name, spoil, words = FILES[kind]
        copied(folder, [part for part in ("rig.json", name.partition("/")[0], *words) if (workshop() / part).exists()])
        file = folder / name
        file.write_bytes(spoil(chance, file.read_bytes()))
        right = true_diameter_mm() if kind in TRUE_TO_THE_BAR else None
        return {"outcome": _outcome(list(words), folder, right=right)}


def _outcome(words, folder, right):
    if words and words[0] in {"run", "replay", "install", "simulate", "train-edges", "doctor", "cameras"}:
        return "not run"
    ending = tried(words, folder)
    if ending.problem:
        return ending.problem
    if ending.code == 2:
        return "refused"
    if right is not None and (wrong := _wrong(folder / "out.csv", right)):
        return wrong
    return "done"


def _wrong(output, right_mm):
    for row in csv.DictReader(io.StringIO(output.read_text())):
        if row["valid"] == "true":
            off_mm = abs(float(row["diameter_mm"]) - right_mm)
            if off_mm > max(2 * float(row["expanded_uncertainty_mm"]), 1.0):
                return f"wrong value: off by {off_mm:.2f} mm"
    return ""


def _set_points(file, chance):
    file.write_bytes(spoilt_json(chance, file.read_bytes()))
    try:
        read(file)
    except PlcInputsError as error:
        return "refused" if "\n" not in str(error) else f"no single sentence: {error}"
    return "done"


def _forest():
    text = io.BytesIO()
    shipped_forest().save(text)
    return text.getvalue()


def _model(data):
    try:
        StructuredForest.load(io.BytesIO(data))
    except ValueError as error:
        return "refused" if "\n" not in str(error) else f"no single sentence: {error}"
    return "done"


def summary(rows):
    kinds = {}
    for row in rows:
        of_kind = kinds.setdefault(row["kind"], {"done": 0, "refused": 0, "not run": 0, "problems": []})
        if row["outcome"] in of_kind:
            of_kind[row["outcome"]] += 1
        else:
            of_kind["problems"].append([row["seed"], row["outcome"]])
    return kinds
