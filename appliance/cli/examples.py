"""An example or two of each command, shown by its --help; a test runs them through the parser."""

EXAMPLES: dict[str, tuple[str, ...]] = {
    "run": ("hotgauge run", "hotgauge run --config /etc/hotgauge/hotgauge.toml"),
    "replay": ("hotgauge replay my_line/scenes/line --rig rig.json",),
    "check-config": ("hotgauge check-config hotgauge.toml",),
    "board": ("hotgauge board --squares 8x5 --mm 50", "hotgauge board --squares 9x6 --mm 25 --output board.pdf"),
    "capture": (
        "hotgauge capture boards --output my_rig --squares 8x5 --mm 50",
        "hotgauge capture registration --output my_rig --low-mm 0 --high-mm 200",
        "hotgauge capture recording --output bars --seconds 30 --config hotgauge.toml",
    ),
    "calibrate": (
        "hotgauge calibrate my_rig --output rig.json",
        "hotgauge calibrate my_rig --output rig.json --report calibration.html",
        "hotgauge calibrate my_rig --output rig.json --squares 8 5 --square-mm 50",
    ),
    "measure": (
        "hotgauge measure my_line/scenes/line --rig rig.json --output out.csv",
        "hotgauge measure line --rig rig.json --output out.csv --method virtual-board",
    ),
    "orient": ("hotgauge orient my_ingots/seq01 --references my_ingots --output ingots.jsonl",),
    "fuse": ("hotgauge fuse left.png right.png --rig rig.json --output fused.png",),
    "compare": (
        "hotgauge compare out.csv my_line/scenes/line --plot errors.png",
        "hotgauge compare ingots.jsonl my_ingots/seq01",
    ),
    "reproduce": ("hotgauge reproduce --output report --quick",),
    "simulate": (
        "hotgauge simulate --output my_line",
        "hotgauge simulate --output my_ingots --scene ingots --frames 200",
    ),
    "export": ("hotgauge export --what bars --from 2026-11-27 --to 2026-11-28 --output a.csv",),
    "report": ("hotgauge report --from 2026-11-28T06:00 --to 2026-11-28T14:00 --output a.pdf",),
    "verify": ("hotgauge verify master --rig rig.json --diameter 120.05 --u 0.02",),
    "gauge-study": ("hotgauge gauge-study study.csv --tolerance 4",),
    "train-edges": ("hotgauge train-edges --output forest.npz --seed 2",),
    "registers": ("hotgauge registers --format csv --bom > registers.csv", "hotgauge registers --format st --plc tia"),
    "install": ("hotgauge install --root preview", "hotgauge install --remove"),
    "cameras": ("hotgauge cameras",),
    "doctor": ("hotgauge doctor --config hotgauge.toml",),
    "certificates": (
        "hotgauge certificates --output certificates --host gauge.mill",
        "hotgauge certificates --output certificates --client plc --role engineer",
    ),
    "page": ("hotgauge page", "hotgauge page --config hotgauge.toml"),
    "page-user": ("hotgauge page-user anna --role operator", "hotgauge page-user anna --remove"),
    "plan": (
        "hotgauge plan --sensor 2448x2048 --pixel-um 3.45 --focal-mm 25 --distance-m 3",
        "hotgauge plan --sensor 800x600 --pixel-um 5 --focal-mm 9 --distance-m 3",
    ),
    "poll": ("hotgauge poll 127.0.0.1", "hotgauge poll gauge.mill:502 --count 1 --json"),
}
