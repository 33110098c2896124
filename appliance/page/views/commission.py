"""The view of commissioning: board pictures, calibration, verification, confirmation, and what the line needs then."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from appliance.page.access.logins import Login
from appliance.page.commissioning import Commissioning, CommissioningError
from appliance.page.parts import Parts
from appliance.page.texts import Texts
from plc.poll import Snapshot

MASTER_MAX_MM = 10_000.0
LEAST_HEIGHT_MM = -1000.0  # of a board's face above the rollers: they may lie above the zero that was chosen
USUAL_REGION_MM = (-250.0, 250.0)  # as of the command calibrate
ENDS = ("top", "bottom")


def values(parts: Parts, texts: Texts, login: Login, query: Mapping[str, str]) -> dict[str, Any]:
    """What the view shows.

    Parameters
    ----------
    parts : Parts
    texts : Texts
    login : Login
    query : mapping of str to str
        `folder`: the one that is worked on; without: the last of the list.
    """
    commissioning = parts.commissioning
    names = commissioning.names(with_boards=True)
    wanted = query.get("folder", "")
    name = wanted if wanted in names else (names[-1] if names else "")
    steps = commissioning.steps(name) if name else {}
    return live(parts, texts, login) | {
        "place": str(commissioning.folder),
        "rig": "" if commissioning.rig is None else str(commissioning.rig),
        "names": names,
        "name": name,
        "recordings": commissioning.names(with_boards=False),
        "running": commissioning.running,
        "steps": {step: steps.get(step) for step in ("calibrated", "verified")},
        "log": commissioning.log(),
        "region": _region(commissioning.rig),
        "usual_region": USUAL_REGION_MM,
        "references": parts.references,
        "ends": {} if parts.references is None else {end: (parts.references / f"{end}.png").is_file() for end in ENDS},
        "place_of_gauge": f"{parts.watch.place}",
    }


def live(parts: Parts, texts: Texts, _login: Login) -> dict[str, Any]:
    """What renews itself: the board pictures that are being taken, and the link to the PLC.

    Parameters
    ----------
    parts : Parts
    texts : Texts
    """
    snapshot = parts.watch.newest
    return {
        "capture": parts.commissioning.board_pictures,
        "gauge_answers": snapshot is not None,
        "wanted": [] if snapshot is None else _wanted(parts, snapshot, texts),
        "link": [(texts("link_gauge"), parts.watch.trouble)] if snapshot is None else _link(snapshot, texts),
    }


def _wanted(parts: Parts, snapshot: Snapshot, texts: Texts) -> list[tuple[str, str, str]]:
    """Target and tolerances that count now: name, number, and who has set it."""
    wanted = parts.watch.wanted(snapshot)
    rows = {
        "target": (wanted.target_mm, "target_diameter"),
        "tolerance_plus": (wanted.tolerance_plus_mm, "tolerance_plus"),
        "tolerance_minus": (wanted.tolerance_minus_mm, "tolerance_minus"),
    }
    shown: list[tuple[str, str, str]] = []
    for name, (value_mm, register) in rows.items():
        by = "" if value_mm is None else texts("by_plc" if snapshot.set_points[register] else "by_settings")
        shown.append((texts(f"wanted_{name}"), texts("not_set") if value_mm is None else texts.number(value_mm), by))
    return shown


def _link(snapshot: Snapshot, texts: Texts) -> list[tuple[str, str]]:
    """What the page reads as a PLC does, and what the PLC has written."""
    written = [name for name, value in snapshot.set_points.items() if value]
    is_silent = "alarm_plc_silent" in snapshot.alarms
    return [
        ("test_float", f"{snapshot.values['test_float']:.3f}"),
        ("test_u32", f"{snapshot.values['test_u32']:.0f}"),
        ("heartbeat", f"{snapshot.values['heartbeat']:.0f}"),
        (texts("link_written"), ", ".join(written) or texts("link_nothing")),
        ("plc_heartbeat", texts("link_silent" if is_silent else "link_not_silent")),
    ]


def _region(rig: Path | None) -> tuple[float, float] | None:
    """Measuring region of the rig file that the gauge uses, mm; None without a readable one."""
    try:
        first_mm, last_mm = json.loads(b"" if rig is None else rig.read_bytes())["region_y_mm"]
        return float(first_mm), float(last_mm)
    except (OSError, ValueError, KeyError, TypeError):
        return None


def act(commissioning: Commissioning, step: str, form: Mapping[str, str], who: str) -> None:
    """Do one step of a form.

    Parameters
    ----------
    commissioning : Commissioning
    step : {"capture", "stop", "calibrate", "verify", "confirm"}
    form : mapping of str to str
    who : str

    Raises
    ------
    BoardPicturesError, CommissioningError
    """
    name = form.get("folder", "")
    if step == "capture":
        what = form.get("what", "")
        is_pose = what == "boards"
        length_mm = _length(form, "square" if is_pose else what, least_mm=1.0 if is_pose else LEAST_HEIGHT_MM)
        commissioning.board_pictures.begin(name, what, form.get("squares", ""), length_mm)
    elif step == "stop":
        commissioning.board_pictures.stop()
    elif step == "calibrate":
        is_told = "first" in form or "last" in form
        region = [_length(form, key, least_mm=-MASTER_MAX_MM) for key in ("first", "last")] if is_told else None
        commissioning.calibrate(name, who, None if region is None else (region[0], region[1]))
    elif step == "verify":
        sizes = _length(form, "diameter"), _length(form, "expanded")
        commissioning.verify(name, who, form.get("recording", ""), *sizes)
    else:
        commissioning.confirm(name, who)


def _length(form: Mapping[str, str], key: str, least_mm: float = 0.0) -> float:
    text = form.get(key, "")
    try:
        number = float(text.replace(",", "."))
    except ValueError:
        number = math.nan
    if not least_mm <= number < MASTER_MAX_MM:
        raise CommissioningError(f"{text!r}: no length; give millimetres, as 120.05")
    return number
