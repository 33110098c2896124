"""The view of the cameras: their newest pictures, and the figures for aiming, focusing and exposing them."""

import time
from typing import Any

from appliance.page.access.logins import Login
from appliance.page.parts import Parts
from appliance.page.previews import Preview
from appliance.page.texts import Texts

STATIONS = ("sizing", "ingot")
SIDES = ("left", "right")

FIGURES: dict[str, tuple[str, int, float]] = {
    "exposure_us": ("µs", 0, 1),
    "limb_light": ("%", 0, 100),
    "clipped_share": ("%", 1, 100),
    "diameter_mm": ("mm", 2, 1),
    "plane_height_mm": ("mm", 1, 1),
    "alignment_quality": ("%", 1, 1),
    "ssim_top": ("", 3, 1),
    "ssim_bottom": ("", 3, 1),
}
"""Figures that are shown beside pictures: unit, digits and factor."""


def values(parts: Parts, texts: Texts, _login: Login) -> dict[str, Any]:
    """What the view shows now.

    Parameters
    ----------
    parts : Parts
    texts : Texts
    """
    return {"stations": [_station(parts, texts, station) for station in STATIONS]}


def _station(parts: Parts, texts: Texts, station: str) -> dict[str, Any]:
    preview = parts.previews.newest(station)
    if preview is None:
        return {"name": station, "pictures": [], "figures": []}
    return {
        "name": station,
        "pictures": [_picture(parts, texts, station, preview, number) for number in range(len(preview.pictures))],
        "figures": _figures(preview, texts),
    }


def _picture(parts: Parts, texts: Texts, station: str, preview: Preview, number: int) -> dict[str, Any]:
    alone = len(preview.pictures) == 1
    return {
        "address": parts.previews.address(station, number),
        "name": texts("camera" if alone else f"camera_{SIDES[number]}"),
        "sharpness": preview.figures.get(f"sharpness_{number}"),
    }


def _figures(preview: Preview, texts: Texts) -> list[tuple[str, str]]:
    figures = preview.figures
    age_s = max(0.0, time.time() - float(figures["exposed_utc_ms"]) / 1000)
    shown = [(texts("age"), f"{texts.number(age_s, 1)} s")]
    if preview.rate_hz is not None:
        shown.append((texts("rate"), f"{texts.number(preview.rate_hz, 1)} / s"))
    if figures.get("windows_total"):
        shown.append((texts("windows"), f"{figures['windows_kept']} / {figures['windows_total']}"))
    for name, (unit, digits, factor) in FIGURES.items():
        value = figures.get(name)
        if value is not None:
            shown.append((texts(f"figure_{name}"), f"{texts.number(factor * float(value), digits)} {unit}".strip()))
    return shown
