"""How far coders displace whole straight edges of grey pictures whose code values follow light, by real coders."""

import numpy as np
from coded_pictures import DEEPER_CODINGS, all_sent
from scipy import special

from studies.served_diameter import rounded
from vision.compression import quantiser_step, u_place_px
from vision.edges.subpixel import half_level_crossing
from vision.geometry.robust_line import robust_line
from vision.sizing.conveyor.barriers import across
from vision.sizing.conveyor.grey_light import grey_light

TEXT = (
    "Two upright edges of steps of 0.08 to 0.4 of full scale that stay (still) and two of 0.3 to 0.8 that come in the "
    "third frame (bar), leaning differently, blurred by 0.9 to 1.7 px, with noise, 640 x 480, coded as PNG, JPEG or "
    "H.264. away_px: displacement of the line through half level, at the middle row, towards the bright side; "
    "q_over_a: the quantiser's step over the edge's; crossed_px: columns that the edge crosses. over_law: RMS of "
    "away_px over the standard uncertainty of vision.compression.u_place_px; powers: of q / A and of 1 + crossed / 8 "
    "in a fit of ln |away|."
)
SEEDS = 30
NAMES = ("png", "jpeg 4:2:0 q90", "jpeg 4:2:0 q75", "h264 crf 18", "h264 crf 23", "h264 crf 28")
SIDES = np.array([-1, 1, -1, 1])  # where it is brighter
KINDS = {"still": (0, 3), "bar": (1, 2)}
SIZE_PX = (480, 640)
OFFSETS_PX = np.arange(-9.0, 9.25, 0.25)
LEAST_AWAY_PX = 0.002


def cases():
    return [{"seed": seed, "coding": name} for seed in range(SEEDS) for name in NAMES]


def run(case):
    rng = np.random.default_rng([case["seed"], 0x6365])
    rows, columns = SIZE_PX
    middle = np.array([rng.uniform(*span) for span in ((100, 150), (260, 285), (330, 360), (470, 520))])
    slope = np.array([rng.uniform(*span) for span in ((-0.25, 0), (-0.04, 0.04), (-0.04, 0.04), (0, 0.25))])
    step = np.array([rng.uniform(0.08, 0.4), rng.uniform(0.3, 0.8)])[[0, 1, 1, 0]]
    dark, blur_px, noise = rng.uniform(0.05, 0.15), rng.uniform(0.9, 1.7), rng.uniform(0.003, 0.012)
    y, x = np.mgrid[:rows, :columns].astype(float)
    seen = [
        special.ndtr(side * (x - at - lean * (y - rows / 2)) / np.hypot(1, lean) / blur_px)
        for side, at, lean in zip(SIDES, middle, slope, strict=True)
    ]
    empty = dark + step[0] * seen[0] + step[3] * seen[3]
    lights = [empty, empty, empty + step[1] * (seen[1] + seen[2] - 1)]
    pictures = [np.rint(255 * np.clip(one + noise * rng.standard_normal(one.shape), 0, 1)) for one in lights]
    coding = DEEPER_CODINGS[case["coding"]]
    grey = [np.repeat(one.astype(np.uint8)[:, :, None], 3, axis=2) for one in pictures]
    sent = all_sent(grey, coding)
    light = [grey_light(one) for one in sent]
    crossed_px = np.abs(slope) * rows
    away, ratio, law = [], [], []
    for number, (side, at, lean) in enumerate(zip(SIDES, middle, slope, strict=True)):
        frame = 2 if number in KINDS["bar"] else 0
        line = np.array([lean, at - lean * rows / 2])
        away.append(rounded(_away_px(light[frame], line, int(side), blur_px)))
        coded = sent[frame].coding
        ratio.append(rounded(quantiser_step(coded) / (coded.span_codes * step[number])))
        law.append(rounded(u_place_px(coded, coded.span_codes * step[number], crossed_px[number])))
    return {"away_px": away, "q_over_a": ratio, "crossed_px": [rounded(one) for one in crossed_px], "law_px": law}


def _away_px(light, line, side, blur_px):
    rows = np.arange(4.0, SIZE_PX[0] - 4)
    profile = across(light, line, side, rows, OFFSETS_PX)
    place = half_level_crossing(profile, OFFSETS_PX, blur_px, expected_px=0.0).place_px
    near = np.abs(place) < 2
    return np.polyval(robust_line(rows[near], place[near]), SIZE_PX[0] / 2)


def summary(rows):
    told = {name: {kind: _of(rows, name, kind) for kind in KINDS} for name in NAMES}
    return told | {"powers": {coder: _powers(rows, coder) for coder in ("jpeg", "h264")}}


def _picked(rows, kind, key):
    return np.array([[row[key][edge] for edge in KINDS[kind]] for row in rows]).ravel()


def _of(rows, name, kind):
    mine = [row for row in rows if row["coding"] == name]
    away, law, ratio = (_picked(mine, kind, key) for key in ("away_px", "law_px", "q_over_a"))
    return {
        "edges": len(away),
        "bias_px": rounded(away.mean()),
        "rms_px": rounded(np.sqrt(np.mean(away**2))),
        "median_q_over_a": rounded(np.median(ratio)),
        "over_law": rounded(np.sqrt(np.mean((away / law) ** 2))) if law.all() else None,
    }


def _powers(rows, coder):
    mine = [row for row in rows if row["coding"].startswith(coder)]
    away, ratio, crossed = (
        np.array([row[key] for row in mine]).ravel() for key in ("away_px", "q_over_a", "crossed_px")
    )
    known = np.column_stack([np.log(ratio), np.log(1 + crossed / 8), np.ones(len(ratio))])
    powers, *_ = np.linalg.lstsq(known, np.log(np.maximum(np.abs(away), LEAST_AWAY_PX)), rcond=None)
    return [rounded(one) for one in powers[:2]]
