"""What a recording of the black box holds of its gauge, and the gauge that is made from it again."""

import json
import math
from collections.abc import Mapping
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from appliance.black_box.black_box import BOX_FILE
from appliance.cameras.source import CameraError
from appliance.sizing.method import SizingMethod, TimedReader
from appliance.sizing.settings import Sizing

SETTINGS_FILE = "settings.json"
SCALE_FOLDER = "scale"  # a folder of its own: a picture of the empty line beside the others would count as a frame


def recorded_settings(settings: SizingMethod, gauge: TimedReader) -> Mapping[str, bytes]:
    """Files by which the gauge is made again: settings and scale, by path in the recording.

    Parameters
    ----------
    settings : SizingMethod
    gauge : TimedReader
        Made from them.
    """
    files = gauge.scale_files
    if files:
        settings = settings.with_scale_files({file.setting: Path(SCALE_FOLDER) / file.name for file in files})
    copies = {f"{SCALE_FOLDER}/{file.name}": file.content for file in files}
    return copies | {SETTINGS_FILE: settings.model_dump_json(indent=1).encode()}


def brings_settings(recording: Path) -> bool:
    """Whether a recording holds the settings and the scale of its own gauge."""
    return (recording / SETTINGS_FILE).is_file() and (recording / BOX_FILE).is_file()


def recorded_gauge(recording: Path) -> tuple[SizingMethod, TimedReader]:
    """Settings and gauge of a recording of the black box, as before its first frame.

    Parameters
    ----------
    recording : Path

    Raises
    ------
    CameraError
        A file of the recording cannot be read.
    ScaleError
        Its rig or its empty line cannot be used.
    """
    try:
        text = (recording / SETTINGS_FILE).read_text(encoding="utf-8")
        settings = TypeAdapter[SizingMethod](Sizing).validate_json(text, context={"folder": recording})
        carried = json.loads((recording / BOX_FILE).read_text(encoding="utf-8"))["carried"]
        gauge = settings.make_gauge(_nothing)
        gauge.resume([math.nan if number is None else float(number) for number in carried])
    except (OSError, ValidationError, ValueError, KeyError, TypeError) as error:
        raise CameraError(f"{recording}: its settings cannot be used ({error}); copy the recording again") from error
    return settings, gauge


def _nothing() -> None:
    """Announce nothing: no station starts."""
