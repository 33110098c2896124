"""Makes the ingot reader: references and regions from a folder, limits from the settings."""

import json
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from appliance.errors import HotgaugeError
from appliance.ingot.learned_references import LearnedReferencesError, current_number, pair
from appliance.ingot.settings import ComparisonSettings, IngotDecisionSettings, IngotLimits, IngotSettings
from vision.ingot.classifiers.similarity import Comparison, Exponents
from vision.ingot.end_finder import Box, EndFinder, EndLimits
from vision.ingot.orientation_reader import IngotView, OrientationReader, References
from vision.ingot.sequential_decision import DecisionRule

Picture = NDArray[np.uint8]

# chosen: defaults without roi.json and settings; x, y, width, height as shares of the picture, for a line that runs
# up its middle
CROP_SHARE = (0.25, 0.2, 0.5, 0.8)
CENTROID_SHARE = (0.33, 0.3, 0.34, 0.55)


class ReferencesError(HotgaugeError):
    """References, regions or limits cannot be used; the message says what, where and what to do."""


def load_view(folder: Path) -> IngotView:
    """Read the references in use, those of `top.png` and `bottom.png` unless others were learned, and `roi.json`.

    Raises
    ------
    ReferencesError
        A file is missing, unreadable or malformed.
    """
    try:
        top, bottom = pair(folder, current_number(folder))
    except LearnedReferencesError as error:
        raise ReferencesError(f"{error}; references are top.png and bottom.png") from error
    return IngotView(References(top, bottom), *_regions(folder / "roi.json"))


def _regions(file: Path) -> tuple[Box | None, Box | None]:
    try:
        regions = json.loads(file.read_text(encoding="utf-8-sig"))
        return _box(regions["roi_crop"]), _box(regions["roi_centroid"])
    except FileNotFoundError:
        return None, None
    except OSError as error:
        raise ReferencesError(f"{file}: cannot be read ({error.strerror}); check its permissions") from error
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as error:
        raise ReferencesError(
            f"{file}: no regions in it; give roi_crop and roi_centroid as [x, y, width, height] in whole pixels"
        ) from error


def _box(numbers: object) -> Box:
    box = Box(*(int(number) for number in cast("list[Any]", numbers)))
    if min(box.x, box.y) < 0 or min(box.width, box.height) < 1:
        raise ValueError(f"{tuple(box)} is no box")
    return box


class IngotRegions(NamedTuple):
    """Where in the picture ends are looked for.

    Attributes
    ----------
    crop, centroid : Box
    """

    crop: Box
    centroid: Box


def ingot_regions(settings: IngotSettings, view: IngotView | None, picture: Picture) -> IngotRegions:
    """Regions of the settings, else of the view, else shares of the picture.

    Parameters
    ----------
    settings : IngotSettings
    view : IngotView or None
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        One of the pictures to be read.

    Raises
    ------
    ReferencesError
        The picture does not hold the crop.
    """
    rows, columns = picture.shape[:2]
    own_crop, own_centroid = (None, None) if view is None else (view.crop, view.centroid)
    crop = Box(*settings.crop) if settings.crop else own_crop or _share(CROP_SHARE, rows, columns)
    centroid = Box(*settings.centroid) if settings.centroid else own_centroid or _share(CENTROID_SHARE, rows, columns)
    if crop.x + crop.width > columns or crop.y + crop.height > rows:
        raise ReferencesError(
            f"the crop {list(crop)} does not lie in pictures of {columns} x {rows}; set ingot.crop or mend roi.json"
        )
    return IngotRegions(crop, centroid)


def make_finder(regions: IngotRegions, limits: IngotLimits, picture: Picture) -> EndFinder:
    """Make the finder of ends for pictures of this size.

    Parameters
    ----------
    regions : IngotRegions
    limits : IngotLimits
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        One of the pictures to be read.

    Raises
    ------
    ReferencesError
        The limits exclude everything.
    """
    try:
        return EndFinder(*regions, _limits(limits, picture.shape[1]))
    except ValueError as error:
        raise ReferencesError(f"ingot.limits: {error}") from error


def make_reader(settings: IngotSettings, view: IngotView, picture: Picture) -> OrientationReader:
    """Make the reader for pictures of this size.

    Parameters
    ----------
    settings : IngotSettings
    view : IngotView
        References, and regions if there are any.
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        One of the pictures to be read.

    Raises
    ------
    ReferencesError
        The picture does not hold the crop, the limits exclude everything, or a reference is no picture.
    """
    finder = make_finder(ingot_regions(settings, view, picture), settings.limits, picture)
    try:
        return OrientationReader(finder, view.references, settings.classifier, comparison_of(settings.comparison))
    except ValueError as error:
        raise ReferencesError(f"ingot.limits: {error}") from error


def comparison_of(settings: ComparisonSettings) -> Comparison:
    """How ends are compared with the references."""
    exponents = Exponents(settings.luminance, settings.contrast, settings.structure)
    return Comparison(exponents, settings.circular, settings.threshold)


def _share(share: tuple[float, float, float, float], rows: int, columns: int) -> Box:
    x, y, width, height = share
    return Box(int(x * columns), int(y * rows), int(width * columns), int(height * rows))


def _limits(settings: IngotLimits, columns: int) -> EndLimits:
    wide = EndLimits.wide(columns)
    radius_px = settings.radius_min_px or wide.radius_px[0], settings.radius_max_px or wide.radius_px[1]
    of_radius = EndLimits.area_of(radius_px)
    return EndLimits(
        area_px=(settings.area_min_px or of_radius[0], settings.area_max_px or of_radius[1]),
        radius_px=radius_px,
        tilt_deg=settings.tilt_deg,
        red_floor=settings.red_floor,
        warmth=settings.warmth,
        length=settings.length,
        arc=settings.arc,
    )


def decision_rule(settings: IngotDecisionSettings) -> DecisionRule:
    """Make the rule of decision; probabilities are percent in the settings and parts of one in the rule."""
    return DecisionRule(
        false_alarm=settings.false_alarm / 100,
        missed=settings.missed / 100,
        late_false_alarm=settings.late_false_alarm / 100,
        late_missed=settings.late_missed / 100,
        late_frames=settings.late_frames,
        least_frames=settings.least_frames,
        still=settings.still,
        gone_frames=settings.gone_frames,
    )
