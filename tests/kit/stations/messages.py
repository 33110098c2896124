"""Messages of station processes for tests, all fields filled."""

import dataclasses

from appliance.ingot.message import IngotMessage, IngotVerdict
from appliance.sizing.message import ReadingMessage
from vision.readings import OrientationReading, SizeReading
from vision.reasons import IngotReason


def reading(**changes: object) -> ReadingMessage:
    """A valid reading; changes go to the message or to the `SizeReading` in it, wherever the field is."""
    measured, around = _parted(SizeReading, changes)
    values: dict = {"diameter_mm": 250.25, "expanded_uncertainty_mm": 0.2, "windows_kept": 20, "windows_total": 25}
    fields: dict[str, object] = {
        "sequence": 0,
        "exposed_monotonic_s": 100.0,
        "exposed_utc_ms": 1_700_000_000_000,
        "elapsed_ms": 20.0,
        "dropped": 0,
        "simulated": True,
        "reading": SizeReading(**values | measured),
    }
    return ReadingMessage.model_validate(fields | around)


def verdict(**changes: object) -> IngotVerdict:
    fields: dict[str, object] = {
        "ingot": 1,
        "orientation": "top",
        "confidence": 99.5,
        "ssim_top": 0.8,
        "ssim_bottom": 0.7,
        "told_utc_ms": 1_700_000_000_000,
    }
    return IngotVerdict.model_validate(fields | changes)


def ingot_message(**changes: object) -> IngotMessage:
    """A picture with an end; changes go to the message or to the `OrientationReading` in it."""
    seen, around = _parted(OrientationReading, changes)
    values: dict = {"present": True, "ssim_top": 0.81, "ssim_bottom": 0.69, "reasons": IngotReason.NONE}
    fields: dict[str, object] = {
        "sequence": 0,
        "exposed_monotonic_s": 100.0,
        "elapsed_ms": 4.0,
        "dropped": 0,
        "simulated": True,
        "reading": OrientationReading(**values | seen),
        "current": None,
        "told": (),
    }
    return IngotMessage.model_validate(fields | around)


def _parted(kind: type, changes: dict[str, object]) -> tuple[dict, dict]:
    names = {field.name for field in dataclasses.fields(kind)}
    return (
        {name: value for name, value in changes.items() if name in names},
        {name: value for name, value in changes.items() if name not in names},
    )
