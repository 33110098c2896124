"""The stereo gauge with its computing time, which `vision` must not read, and error sentences for a wrong rig."""

import io
import math
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Generic, NamedTuple, Protocol, TypeVar, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.cameras.source import FramePair
from appliance.processes.preview import Line, Lines
from appliance.sizing.method import ScaleFile
from appliance.sizing.stereo.edge_model import load_edge_model
from appliance.sizing.stereo.rig_file import RigError, load_rig
from vision.calibration.rig import Rig
from vision.edges.forest.model import StructuredForest
from vision.edges.names import EdgeMethod
from vision.edges.operators import EdgeOptions
from vision.fusion.names import Fusion
from vision.geometry.camera import Camera
from vision.geometry.measuring_plane import PLANE_HEIGHT_MM
from vision.geometry.surface_point import SurfacePoint
from vision.readings import SizeReading
from vision.sent_picture import Codes, SentPicture
from vision.sizing.gauge import Gauge
from vision.sizing.limits import LIMB_SIDES
from vision.sizing.tangent.tangent_planes import TangentPlane
from vision.sizing.virtual_board.aligned_pair import AlignedPair

Picture = NDArray[np.uint8]
Reading_co = TypeVar("Reading_co", covariant=True)

EDGE_DRAWN_MM = 60.0  # chosen; see `TimedGauge.lines`
REGION_DRAWN_MM = 400.0  # chosen: either way across the line
BOARD_DRAWN_MM = 100.0  # chosen: half of the side of the square that stands for the virtual board
DRAWN_DIAMETER_MM = 150.0  # chosen: bar that `warm_up` draws


class Measures(Protocol[Reading_co]):
    """A gauge that measures a pair of pictures."""

    def measure(self, left: SentPicture | Codes, right: SentPicture | Codes) -> Reading_co:
        """Measure one pair."""
        ...


class TimedGauge(Generic[Reading_co]):
    """A gauge that returns its computing time and refuses pictures of another size than its rig's.

    Parameters
    ----------
    rig : Rig
    name : str
        File or camera of the rig, for error sentences.
    make : callable
        Makes the gauge from the rig.

    Raises
    ------
    RigError
        No diameter can be measured with this rig.
    """

    def __init__(self, rig: Rig, name: str, make: Callable[[Rig], Measures[Reading_co]]) -> None:
        self._rig = rig
        self._name = name
        self._make = make
        try:
            self._gauge = make(rig)
        except ValueError as error:
            raise RigError(f"{name}: {error}; calibrate again") from error

    def warm_up(self) -> None:
        """Measure a drawn bar once, so that code is compiled before the first pair."""
        self._make(self._rig).measure(*(_drawn_bar(camera) for camera in (self._rig.left, self._rig.right)))

    def measure(self, left: SentPicture | Codes, right: SentPicture | Codes) -> tuple[Reading_co, float]:
        """Measure one pair: reading and computing time, ms.

        Parameters
        ----------
        left, right : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)

        Raises
        ------
        RigError
            The pictures do not have the size that the rig was calibrated with.
        """
        readings, elapsed_ms = self._timed(lambda *pictures: (self._gauge.measure(*pictures),), left, right)
        return readings[0], elapsed_ms

    def measure_bars(
        self,
        left: SentPicture | Codes,
        right: SentPicture | Codes,
        *,
        synchronous: bool = False,
        point: SurfacePoint | None = None,
    ) -> tuple[tuple[Reading_co, ...], float]:
        """Measure one pair: a reading for each bar side by side, from smaller x, and computing time, ms.

        Parameters
        ----------
        left, right : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
        synchronous : bool
            Whether time stamps prove that both cameras exposed together.
        point : SurfacePoint or None
            Where a laser meets the bar.

        Raises
        ------
        RigError
            As in `measure`.
        """
        of_bars = getattr(self._gauge, "measure_bars", None)  # a gauge of one bar has none
        if of_bars is None:
            return self._timed(lambda *pictures: (self._gauge.measure(*pictures),), left, right)
        return self._timed(partial(of_bars, synchronous=synchronous, point=point), left, right)

    def _timed(
        self, measure: Callable[..., tuple[Reading_co, ...]], left: SentPicture | Codes, right: SentPicture | Codes
    ) -> tuple[tuple[Reading_co, ...], float]:
        pictures = SentPicture.of(left), SentPicture.of(right)
        self._check_size("left", self._rig.left.image_size, pictures[0].size)
        self._check_size("right", self._rig.right.image_size, pictures[1].size)
        started_s = time.perf_counter()
        readings = measure(*pictures)
        return readings, 1000 * (time.perf_counter() - started_s)

    @property
    def aligned_pair(self) -> AlignedPair | None:
        """Views, edges and board of the last pair, for plots; None of a gauge that aligns none, or of no bar."""
        return getattr(self._gauge, "last_pair", None)

    def lines(self, reading: SizeReading) -> Lines:
        """Measuring region, virtual board and the cylinder's edges, as each camera sees them.

        The edges are drawn for 60 mm either way of y = 0 only: that is where offset and height are of.
        """
        return [_lines(camera, self._rig.region_y_mm, reading) for camera in (self._rig.left, self._rig.right)]

    def _check_size(self, side: str, calibrated: tuple[int, int], size: tuple[int, int]) -> None:
        if size != calibrated:
            raise RigError(
                f"{self._name}: made for {side} pictures of {calibrated[0]} x {calibrated[1]}, these are "
                f"{size[0]} x {size[1]}; use the rig that belongs to these cameras"
            )


class RangeRay(NamedTuple):
    """The beam of a laser beside the cameras; see `RangeSettings`.

    Attributes
    ----------
    origin_mm, direction : sequence of float
        x, y, z in the rig's frame.
    u_mm : float
        Standard uncertainty of the spot's place.
    """

    origin_mm: Sequence[float]
    direction: Sequence[float]
    u_mm: float

    def point(self, range_mm: float, rig: Rig) -> SurfacePoint | None:
        """Where the spot lies, in the line's frame; None without a range.

        Parameters
        ----------
        range_mm : float
        rig : Rig
            Along the line.
        """
        if not math.isfinite(range_mm):
            return None
        origin_mm, direction = (rig.line_axes @ np.array(place) for place in (self.origin_mm, self.direction))
        return SurfacePoint.at(origin_mm, direction, range_mm, self.u_mm)


class LineSetup(NamedTuple):
    """How the line lies against the boards, and what stands beside it.

    Attributes
    ----------
    tilt_deg : float
        Rise along y against the boards; see `Rig.along_line`.
    ray : RangeRay or None
        Beam of a laser beside the cameras, in the boards' frame.
    """

    tilt_deg: float = 0.0
    ray: RangeRay | None = None


USUAL_LINE = LineSetup()


class StationGauge(TimedGauge[SizeReading]):
    """The gauge of a station: another process can make it again and go on where it was.

    Parameters
    ----------
    rig, name, make
        As for `TimedGauge`.
    forest : StructuredForest or None
        Of route V's edges; None: the shipped one.
    ray : RangeRay or None
        Beam of a laser beside the cameras.
    """

    def __init__(
        self,
        rig: Rig,
        name: str,
        make: Callable[[Rig], Gauge],
        forest: StructuredForest | None,
        ray: RangeRay | None = None,
    ) -> None:
        super().__init__(rig, name, make)
        self._forest = forest
        self._ray = ray

    def measure_exposed(self, exposed: FramePair) -> tuple[tuple[SizeReading, ...], float]:
        """Measure an exposure with what its time stamps and its range tell; see `measure_bars`."""
        point = None if self._ray is None else self._ray.point(exposed.range_mm, self._rig)
        return self.measure_bars(*exposed.pictures, synchronous=exposed.synchronous, point=point)

    @property
    def scale_files(self) -> Sequence[ScaleFile]:
        """The rig file, and the forest where it is not the shipped one; see `TimedReader.scale_files`."""
        rig = ScaleFile("rig", "rig.json", self._rig.along_line(0.0).to_json().encode())
        if self._forest is None:
            return (rig,)
        content = io.BytesIO()
        self._forest.save(content)
        return rig, ScaleFile("edge_model", "edge_model.npz", content.getvalue())

    @property
    def carried(self) -> tuple[float, ...]:
        """What the next frame gets of the earlier ones; see `TimedReader.carried`."""
        return cast("Gauge", self._gauge).carried

    def resume(self, carried: Sequence[float]) -> None:
        """Go on as the gauge would whose `carried` this was; see `TimedReader.resume`."""
        height_mm, area_px = carried
        cast("Gauge", self._gauge).resume((height_mm, area_px))


class RouteV(NamedTuple):
    """How route V finds edges and fuses the views.

    Attributes
    ----------
    edges : {"forest", "sobel", "prewitt", "roberts", "canny"}
    edge_model : Path or None
        Forest of `hotgauge train-edges`; None: the shipped one.
    fusion : str
        See `vision.sizing.virtual_board.gauge.VirtualBoardGauge`.
    """

    edges: EdgeMethod = "forest"
    edge_model: Path | None = None
    fusion: Fusion = "none"


USUAL_ROUTE_V = RouteV()


def rig_file_gauge(
    path: Path, ovality_mm: float | None, route_v: RouteV = USUAL_ROUTE_V, line: LineSetup = USUAL_LINE
) -> StationGauge:
    """Make the gauge of a rig file; raises `RigError` as `load_rig` and `TimedGauge` do.

    Parameters
    ----------
    path : Path
    ovality_mm : float or None
        Largest ovality of the product: greatest minus least width of a cross section; None: what is usual.
    route_v : RouteV
    line : LineSetup
    """
    return pair_gauge(load_rig(path), str(path), ovality_mm, route_v, line)


def pair_gauge(
    rig: Rig,
    name: str,
    ovality_mm: float | None,
    route_v: RouteV = USUAL_ROUTE_V,
    line: LineSetup = USUAL_LINE,
) -> StationGauge:
    """Make the gauge of a rig, by both routes; raises `RigError` as `TimedGauge` does, and `EdgeModelError`.

    Parameters
    ----------
    rig : Rig
    name : str
        File or camera of the rig, for error sentences.
    ovality_mm : float or None
        Largest ovality of the product: greatest minus least width of a cross section; None: what is usual.
    route_v : RouteV
    line : LineSetup
    """
    forest = None if route_v.edge_model is None else load_edge_model(route_v.edge_model)
    edges = EdgeOptions(method=route_v.edges, forest=forest)
    make = partial(Gauge, ovality_mm=ovality_mm, edges=edges, fusion=route_v.fusion)
    return StationGauge(rig.along_line(line.tilt_deg), name, make, forest, line.ray)


def _lines(camera: Camera, region_y_mm: tuple[float, float], reading: SizeReading) -> list[Line]:
    return [*_region_lines(camera, region_y_mm), *_board_lines(camera, reading), *_edge_lines(camera, reading)]


def _region_lines(camera: Camera, region_y_mm: tuple[float, float]) -> list[Line]:
    x_mm = np.linspace(-REGION_DRAWN_MM, REGION_DRAWN_MM, 20)
    ends = [np.column_stack([x_mm, np.full(20, y_mm), np.full(20, PLANE_HEIGHT_MM)]) for y_mm in region_y_mm]
    return [Line("region", camera.project(end)) for end in ends]


def _board_lines(camera: Camera, reading: SizeReading) -> list[Line]:
    corners = BOARD_DRAWN_MM * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
    return [Line("board", camera.project(np.column_stack([corners, np.full(5, reading.plane_height_mm)])))]


def _edge_lines(camera: Camera, reading: SizeReading) -> list[Line]:
    if not reading.valid:
        return []
    cylinder = np.array([reading.offset_mm, reading.axis_height_mm, 0.0, 0.0, reading.diameter_mm / 2])
    y_mm = np.array([-EDGE_DRAWN_MM, EDGE_DRAWN_MM])
    return [Line("edge", camera.project(points)) for points in _outline_mm(camera, cylinder, y_mm)]


def _outline_mm(camera: Camera, cylinder: NDArray[np.float64], y_mm: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Both edges of a cylinder as a camera sees them, on the measuring plane, mm."""
    lines = [TangentPlane.touching(camera.centre_mm, cylinder, side).line for side in LIMB_SIDES]
    return [np.column_stack([line[0] * y_mm + line[1], y_mm, np.full(y_mm.size, PLANE_HEIGHT_MM)]) for line in lines]


def _drawn_bar(camera: Camera) -> Picture:
    """Grey picture of a bar on the rollers before a dark background, as one camera would see it."""
    cylinder = np.array([0.0, DRAWN_DIAMETER_MM / 2, 0.0, 0.0, DRAWN_DIAMETER_MM / 2])
    y_mm = np.linspace(-400.0, 400.0, 50)
    edges = _outline_mm(camera, cylinder, y_mm)
    outline = [camera.project(edge)[::side] for side, edge in zip(LIMB_SIDES, edges, strict=True)]
    columns, rows = camera.image_size
    picture = np.full((rows, columns), 8, np.uint8)
    cv2.fillPoly(picture, [np.rint(np.nan_to_num(np.concatenate(outline))).astype(np.int32)], (160,))
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), 1.0), np.uint8)
