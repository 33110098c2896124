"""`hotgauge capture references`: both ends of an ingot as the ingot camera sees them, and where they lie."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from appliance.cameras.source import Frame
from appliance.capture.believed_pairs import believed
from appliance.capture.console import Console
from appliance.capture.error import CaptureError
from appliance.capture.picture_writer import write_document, write_picture
from appliance.ingot.reader_setup import IngotRegions, ingot_regions, load_view, make_finder
from appliance.ingot.settings import IngotSettings
from vision.ingot.classifiers.similarity import similarity
from vision.ingot.end_finder import End
from vision.ingot.end_image import end_image
from vision.ingot.orientation_reader import is_overexposed
from vision.reasons import IngotReason
from vision.sent_picture import SentPicture

ENDS = ("top", "bottom")
WITHIN_S = 60.0
STILL_SHARE = 0.03  # chosen: of the radius, that the end may move from one picture to the next
ALIKE_SSIM = 0.8  # chosen: two references more alike than this are probably the same end

Picture = NDArray[np.uint8]


def capture_references(
    settings: IngotSettings, folder: Path, ends: tuple[str, ...], console: Console, *, asks: bool
) -> None:
    """Write `top.png`, `bottom.png` and `roi.json`.

    Parameters
    ----------
    settings : IngotSettings
    folder : Path
    ends : tuple of str
        Which ends are taken now, in this order.
    console : Console
    asks : bool
        Wait for the Enter key before each end.

    Raises
    ------
    CaptureError
        No end that lies still was seen in time (the sentence says what was seen), or both look alike.
    CameraError, ReferencesError
        The camera gives no pictures; the regions do not lie in them.
    """
    for end in ends:
        if asks:
            console.wait_for_enter(f"lay an ingot on the line with its {end} facing the camera")
        picture, regions = _still_end(settings, end, console)
        write_picture(folder / f"{end}.png", SentPicture.of(picture))
        write_document(folder / "roi.json", _document(regions))
        console.say(f"{folder / end}.png: stored")
    _compare(folder)


def _document(regions: IngotRegions) -> dict[str, object]:
    return {"roi_crop": list(regions.crop), "roi_centroid": list(regions.centroid), "box": "x, y, width, height"}


def _still_end(settings: IngotSettings, name: str, console: Console) -> tuple[Picture, IngotRegions]:
    trouble = "no picture came"
    before: End | None = None
    with settings.camera.make_source() as source:
        for frame in believed(source, settings.liveness, WITHIN_S):
            if not isinstance(frame, Frame):
                raise TypeError("a source of single pictures is needed")
            regions = ingot_regions(settings, None, frame.picture)
            end, reasons = make_finder(regions, settings.limits, frame.picture).find(frame.picture)
            trouble = _trouble(frame.picture, end, reasons, before)
            if end is not None and not trouble:
                return end_image(frame.picture, end), regions
            console.live(f"{name}: {trouble}")
            before = end
    raise CaptureError(f"no {name} of an ingot to be used within {WITHIN_S:g} s: {trouble}")


def _trouble(picture: Picture, end: End | None, reasons: IngotReason, before: End | None) -> str:
    if end is None:
        seen = ", ".join(reason.name.lower() for reason in reasons if reason.name)
        return f"no end on the line ({seen}); see ingot.crop, ingot.centroid and ingot.limits"
    if is_overexposed(picture, end):
        return "overexposed: expose for a shorter time"
    if before is None:
        return "wait until it lies still"
    way = np.hypot(end.center_x - before.center_x, end.center_y - before.center_y) / end.radius
    return "" if way <= STILL_SHARE else f"it moves by {100 * way:.0f} % of its radius: wait until it lies still"


def _compare(folder: Path) -> None:
    if not all((folder / f"{end}.png").is_file() for end in ENDS):
        return
    references = load_view(folder).references
    alike = similarity(references.top, references.bottom)
    if alike > ALIKE_SSIM:
        raise CaptureError(f"{folder}: top.png and bottom.png look alike (SSIM {alike:.2f}); is one end there twice?")
