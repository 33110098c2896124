"""Messages of station processes for tests, all fields filled."""

from appliance.ingot.message import IngotMessage, IngotVerdict
from appliance.sizing.message import ReadingMessage


def reading(**changes: object) -> ReadingMessage:
    fields: dict[str, object] = {
        "sequence": 0,
        "exposed_monotonic_s": 100.0,
        "exposed_utc_ms": 1_700_000_000_000,
        "elapsed_ms": 20.0,
        "dropped": 0,
        "simulated": True,
        "valid": True,
        "reasons": 0,
        "diameter_mm": 250.25,
        "expanded_uncertainty_mm": 0.2,
        "diameter_virtual_board_mm": None,
        "weighted_deviation_mm": None,
        "windows_kept": 20,
        "windows_total": 25,
        "alignment_quality": None,
        "plane_height_mm": None,
    }
    return ReadingMessage.model_validate(fields | changes)


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
    fields: dict[str, object] = {
        "sequence": 0,
        "exposed_monotonic_s": 100.0,
        "elapsed_ms": 4.0,
        "dropped": 0,
        "simulated": True,
        "present": True,
        "reasons": 0,
        "ssim_top": 0.81,
        "ssim_bottom": 0.69,
        "current": None,
        "told": (),
    }
    return IngotMessage.model_validate(fields | changes)
