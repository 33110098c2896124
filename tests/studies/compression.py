"""By which share of the way to the middle of its code values compression moves an edge, by real coders."""

import zlib

import numpy as np
from coded_pictures import through_video
from scipy import special
from scipy.optimize import least_squares

from appliance.cameras.recording.picture_file import decoded_picture
from appliance.simulation.coding import jpeg
from appliance.simulation.video_coding import Video
from studies.served_diameter import rounded
from vision.compression import JPEG, JPEG_COLOUR, VIDEO, quantiser_step
from vision.sent_picture import Coding

TEXT = (
    "Straight edges at random angles and places, blurred in light, coded by a power law with noise, then by libjpeg or "
    "x264, and decoded under the true law. share: how far half level moved, over the distance between the middle in "
    "code values and in light; mean and standard error over the pictures. jpeg colour: red of a red-hot bar, whole "
    "colour resolution. fitted: k, p and c of k (q / A)^p exp(-c (blur - 0.8)); used: those of vision.compression; "
    "off: relative deviation, RMS, of the shares from the law that is used, less what their standard errors explain."
)
LAWS = {"jpeg": JPEG, "jpeg colour": JPEG_COLOUR, "h264": VIDEO}
QUALITIES = {"jpeg": (95, 90, 82, 75, 50), "jpeg colour": (95, 90, 82, 75, 50), "h264": (18, 21, 23, 25, 28)}
LEVELS = ((0.02, 0.9), (0.03, 0.42), (0.05, 0.25))
BAR = np.array([0.06, 0.33, 1.0])  # blue and green of a red-hot bar, over red
EXPONENTS = (1.6, 2.4)
BLURS_PX = (0.65, 0.8, 1.0, 1.25)
SIZE_PX, PICTURES, FRAMES, NOISE = 160, 8, 3, 0.01
BINS_PER_PX, REACH_PX = 4, 8
LEAST_U = 0.002


def cases():
    return [
        {"coder": coder, "quality": quality, "exponent": exponent, "dark": dark, "bright": bright, "blur_px": blur_px}
        for coder, qualities in QUALITIES.items()
        for quality in qualities
        for exponent in EXPONENTS
        for dark, bright in (LEVELS[:1] if coder == "jpeg colour" else LEVELS)
        for blur_px in BLURS_PX
    ]


def run(case):
    rng = np.random.default_rng(zlib.crc32(repr(case).encode()))
    dark, bright, exponent = case["dark"], case["bright"], case["exponent"]
    low, high = dark ** (1 / exponent), bright ** (1 / exponent)
    middle = (0.5 * (low + high)) ** exponent
    away_px = -case["blur_px"] * special.ndtri((middle - dark) / (bright - dark))
    moved, quantisers = zip(*(_moved_px(case, rng) for _ in range(PICTURES)), strict=True)
    moved = np.array(moved) / away_px
    return {
        "quantiser": rounded(np.mean(quantisers)),
        "step_codes": rounded(255 * (high - low)),
        "share": rounded(np.mean(moved)),
        "u_share": rounded(np.std(moved) / np.sqrt(PICTURES)),
    }


def _moved_px(case, rng):
    angle = rng.uniform(-0.6, 0.6) + np.pi / 2 * rng.integers(4)
    y, x = np.mgrid[:SIZE_PX, :SIZE_PX] - SIZE_PX / 2
    distance = (x - rng.uniform(-4, 4)) * np.cos(angle) + y * np.sin(angle)
    share = special.ndtr(distance / case["blur_px"])[..., None]
    top = case["bright"] * (BAR if case["coder"] == "jpeg colour" else np.ones(3))
    light = case["dark"] + share * (top - case["dark"])
    pictures = [_exposed(light, case, rng) for _ in range(FRAMES if case["coder"] == "h264" else 1)]
    sent = _sent(pictures, case)
    coding = sent.coding
    codes = (sent.measured[:, :, -1].astype(np.float64) - coding.black) / (coding.white - coding.black)
    before, after = (
        _half_level_px(distance, np.maximum(one, 0) ** case["exponent"])
        for one in (pictures[-1][..., 2] / 255.0, codes)
    )
    return after - before, coding.quality if coding.quantiser is None else coding.quantiser


def _exposed(light, case, rng):
    grey = case["coder"] != "jpeg colour"
    noise = rng.standard_normal((*light.shape[:2], 1 if grey else 3))
    noisy = np.clip(light + NOISE * np.sqrt(light) * noise, 0, 1)
    return np.rint(255 * noisy ** (1 / case["exponent"])).astype(np.uint8)


def _sent(pictures, case):
    if case["coder"] == "h264":
        return through_video(pictures, Video(case["quality"]))
    picture = pictures[-1] if case["coder"] == "jpeg colour" else np.ascontiguousarray(pictures[-1][..., 0])
    return decoded_picture(jpeg(picture, case["quality"], "4:4:4"))


def _half_level_px(distance, light):
    """Where the mean profile is halfway between its plateaus."""
    place = np.floor((distance + REACH_PX) * BINS_PER_PX).astype(int)
    bins = 2 * REACH_PX * BINS_PER_PX
    there = (place >= 0) & (place < bins)
    count = np.bincount(place[there], minlength=bins)
    filled = count > 0  # edges along rows or columns leave some bins empty
    profile = np.bincount(place[there], light[there], bins)[filled] / count[filled]
    at = ((np.arange(bins) + 0.5) / BINS_PER_PX - REACH_PX)[filled]
    half = 0.5 * (profile[at < -4].mean() + profile[at > 4].mean())
    near = np.abs(at) < 3
    return np.interp(half, profile[near], at[near])


def summary(rows):
    return {coder: _law([row for row in rows if row["coder"] == coder], law) for coder, law in LAWS.items()}


def _law(rows, used):
    step = np.array([_step(row) / row["step_codes"] for row in rows])
    blur, share, u = (np.array([row[key] for row in rows]) for key in ("blur_px", "share", "u_share"))
    doubt = np.hypot(np.maximum(u, LEAST_U), 0.3 * np.abs(share))

    def of(factor, power, slope):
        return factor * step**power * np.exp(-slope * (blur - 0.8))

    def off(values):
        return (of(np.exp(values[0]), *values[1:]) - share) / doubt

    factor, power, slope = least_squares(off, [0.0, 1.0, 2.0]).x
    law = of(*used)
    large = law > 0.02
    relative = np.mean((share[large] / law[large] - 1) ** 2 - (u[large] / law[large]) ** 2)
    return {
        "cases": len(rows),
        "fitted": [rounded(np.exp(factor)), rounded(power), rounded(slope)],
        "used": [rounded(one) for one in used],
        "off": rounded(np.sqrt(max(relative, 0.0))),
    }


def _step(row):
    quality = row["quantiser"]
    coding = Coding(
        "grey", compression="video" if row["coder"] == "h264" else "jpeg", quality=quality, quantiser=quality
    )
    return quantiser_step(coding)
