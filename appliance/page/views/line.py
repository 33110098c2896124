"""The view of the line: size, decision, alarms, trend, ingot and health."""

import time
from typing import Any

from markupsafe import Markup

from appliance.diagnostics.alarms import ALARMS
from appliance.diagnostics.named_bits import named_bits
from appliance.page.access.logins import Login
from appliance.page.drawing import Frame, Limits, chart
from appliance.page.parts import Parts
from appliance.page.texts import Texts
from appliance.page.watch import NO_SET_POINTS, TREND_S, Watch
from plc.bars import BAR_FIELDS, BAR_SLOTS
from plc.codes import NamedBit, Orientation, Validity
from plc.poll import Snapshot
from plc.security.roles import Role

MARKS = {"high": "■", "medium": "▲", "low": "●"}
DECISION_MARKS = ("·", "✓", "◆", "?")
STATE_MARKS = ("✓", "▲", "▲", "◇", "■")
ENDS = {
    Orientation.NONE: "none",
    Orientation.TOP: "top",
    Orientation.BOTTOM: "bottom",
    Orientation.UNDECIDED: "undecided",
}
END_MARKS = {"none": "·", "top": "■", "bottom": "✓", "undecided": "?"}

TREND_GAP_S = 2.0  # chosen: of a line at 10 readings a second, or at 1

SIZES = {
    "hot": "diameter",
    "expanded": "expanded_uncertainty",
    "cold": "diameter_cold",
    "expanded_cold": "expanded_uncertainty_cold",
    "trust": "trust",
}
_ADVICE = ("deviation", "correction")

_BITS = named_bits()
_SHOWS_NO_END = {"nothing_hot", "starting"}  # an empty line is no trouble, and a station that is off neither


def values(parts: Parts, texts: Texts, login: Login) -> dict[str, Any]:
    """What the view shows now.

    Parameters
    ----------
    parts : Parts
    texts : Texts
    login : Login
    """
    snapshot = parts.watch.newest
    return {
        "gauge": snapshot is not None,
        "trouble": parts.watch.trouble,
        "notes": [] if snapshot is None else _notes(snapshot, texts),
        "size": _size(snapshot, texts),
        "judged": _judged(parts.watch, snapshot),
        "alarms": [] if snapshot is None else _alarms(snapshot, texts),
        "may_acknowledge": login.may(Role.OPERATOR),
        "trend": _trend(parts.watch, snapshot, texts),
        "ingot": _ingot(snapshot, texts, parts),
        "side_by_side": [] if snapshot is None else _side_by_side(snapshot, texts),
        "bars": parts.watch.bars,
        "health": _health(snapshot, texts),
    }


def _notes(snapshot: Snapshot, texts: Texts) -> list[str]:
    held = any(bit.name == "held" for bit in _on(snapshot, "reason_word"))
    return [
        *([texts("simulated")] if snapshot.discretes["simulated"] else []),
        *([texts("held")] if held else []),
    ]


def _on(snapshot: Snapshot, word: str) -> list[NamedBit]:
    number = int(snapshot.values[word] or 0)
    return [bit for bit in _BITS[word] if number >> bit.bit & 1]


def _size(snapshot: Snapshot | None, texts: Texts) -> dict[str, Any]:
    if snapshot is None:
        return {"valid": False, "reasons": [], **dict.fromkeys(SIZES)}
    valid = snapshot.values["validity"] != int(Validity.NONE)
    return {
        "valid": valid,
        "reasons": [texts.reason(bit) for bit in _on(snapshot, "reason_word")],
        **{key: snapshot.values[name] if valid else None for key, name in SIZES.items()},
    }


def _side_by_side(snapshot: Snapshot, texts: Texts) -> list[dict[str, Any]]:
    """Bars that pass side by side; empty for one or none, which the measurement block holds."""
    shown: list[dict[str, Any]] = []
    for number in range(1, BAR_SLOTS + 1) if snapshot.bars.get("bars_count") else ():
        slot = {name: snapshot.bars[f"bar_{number}_{name}"] for name in BAR_FIELDS}
        valid = slot["validity"] != int(Validity.NONE)
        if not valid and not slot["reason_word"]:
            continue
        reasons = [bit for bit in _BITS["reason_word"] if int(slot["reason_word"] or 0) >> bit.bit & 1]
        shown.append(
            {
                "number": number,
                "diameter": slot["diameter"] if valid else None,
                "expanded": slot["expanded_uncertainty"] if valid else None,
                "offset": slot["offset"],
                "reasons": [texts.reason(bit) for bit in reasons],
            }
        )
    return shown


def _judged(watch: Watch, snapshot: Snapshot | None) -> dict[str, Any]:
    if snapshot is None:
        return {"decision": 0, "mark": DECISION_MARKS[0], **dict.fromkeys((*_ADVICE, "wanted"))}
    decision = int(snapshot.values["decision"] or 0)
    return {
        "decision": decision,
        "mark": DECISION_MARKS[decision],
        **{name: snapshot.values[name] for name in _ADVICE},
        "wanted": watch.wanted(snapshot),
    }


def _alarms(snapshot: Snapshot, texts: Texts) -> list[dict[str, str]]:
    on = set(snapshot.alarms)
    rows = sorted((row for row in ALARMS if row.name in on), key=lambda row: list(MARKS).index(row.priority))
    shown: list[dict[str, str]] = []
    for row in rows:
        text, remedy = texts.alarm(row.name)
        mark = MARKS[row.priority]
        shown.append({"name": row.name, "priority": row.priority, "mark": mark, "text": text, "remedy": remedy})
    return shown


def _trend(watch: Watch, snapshot: Snapshot | None, texts: Texts) -> Markup:
    wanted = NO_SET_POINTS if snapshot is None else watch.wanted(snapshot)
    limits = limits_of(wanted.target_mm, wanted.tolerance_plus_mm, wanted.tolerance_minus_mm)
    now_s = time.monotonic()
    minutes = range(round(TREND_S / 60) + 1)
    ticks = [(now_s - 60 * minute, f"{-minute} {texts('minutes')}".replace("-", "−")) for minute in minutes]
    frame = Frame(now_s - TREND_S, now_s, TREND_GAP_S, ticks, texts("trend_label"), texts.decimal)
    return Markup(chart(watch.trend, limits, frame))  # noqa: S704  it escapes its words


def limits_of(target_mm: float | None, plus_mm: float | None, minus_mm: float | None) -> Limits:
    """Target with its limits.

    Parameters
    ----------
    target_mm, plus_mm, minus_mm : float or None
        Target, and what is allowed above and below it; None for what is not set.
    """
    return Limits(
        target_mm,
        None if target_mm is None or minus_mm is None else target_mm - minus_mm,
        None if target_mm is None or plus_mm is None else target_mm + plus_mm,
    )


def _ingot(snapshot: Snapshot | None, texts: Texts, parts: Parts) -> dict[str, Any]:
    picture = parts.previews.address("ingot", 0)
    if snapshot is None or not snapshot.values["ingot_validity"]:
        on = [] if snapshot is None else _on(snapshot, "ingot_reason_word")
        reasons = [texts.reason(bit) for bit in on if bit.name not in _SHOWS_NO_END]
        return {"end": "none", "mark": END_MARKS["none"], "number": None, "picture": picture, "reasons": reasons}
    end = ENDS[Orientation(int(snapshot.values["ingot_orientation"] or 0))]
    return {
        "end": end,
        "mark": END_MARKS[end],
        "number": snapshot.values["ingot_sequence"],
        "confidence": snapshot.values["ingot_confidence"],
        "picture": picture,
        "reasons": [],
    }


def _health(snapshot: Snapshot | None, texts: Texts) -> dict[str, Any]:
    if snapshot is None:
        return {"state": 4, "mark": STATE_MARKS[4], "faults": [], "age_ms": None, "cycle_ms": None}
    state = int(snapshot.values["device_state"] or 0)
    return {
        "state": state,
        "mark": STATE_MARKS[state],
        "faults": [texts.fault(bit.name) for bit in _on(snapshot, "fault_word")],
        "age_ms": snapshot.values["measurement_age"],
        "cycle_ms": snapshot.values["cycle_time"],
    }
