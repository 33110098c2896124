"""Route V: the diameter by virtual boards, the dissertation's own method, as printed and corrected.

Boundaries of interest in both views; the virtual board on which the bar's two outlines agree; random regression in
sliding windows; diameters on the plane of that board; windows whose weighted deviation jumps are discarded.
"""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from vision.alignment.height_search import Height, HeightLoop, search_by_overlap
from vision.alignment.quality import BarOutline, Quality
from vision.alignment.view_alignment import Alignment
from vision.alignment.virtual_boards import VirtualBoards
from vision.calibration.rig import Rig
from vision.compression import quantiser_step
from vision.edges.operators import EdgeOptions, Edges
from vision.fusion.methods import fuse
from vision.fusion.names import FUSIONS, Fusion, Method
from vision.geometry.homography import transformed
from vision.geometry.measuring_plane import pixel_size_mm
from vision.geometry.turned_region import Region, RegionSampler, luma_region, picture_region, resampled_region
from vision.light_planes import Decoder
from vision.reasons import Reason
from vision.sent_picture import Codes, SentPicture, sent_picture
from vision.sizing.checked_pictures import checked_pair
from vision.sizing.limits import DIAMETER_MM, OFF_ROLLERS_MM, OFF_ROLLERS_SHARE
from vision.sizing.region_grid import Outline, RegionGrid
from vision.sizing.virtual_board.aligned_pair import AlignedPair
from vision.sizing.virtual_board.bar_tilt import unless_tilted
from vision.sizing.virtual_board.parameters import PRINTED_PARAMETERS, SERVED_PARAMETERS, Parameters
from vision.sizing.virtual_board.reading import CORRECTED, Corrections, VirtualBoardReading
from vision.sizing.virtual_board.tangent_crossing import Section, solve_section, tangent_cuts
from vision.sizing.virtual_board.view_edges import (
    FOREST_MARGIN_PX,
    STRIP_HALF_WIDTH_PX,
    ViewEdges,
    edges_by_lines,
    edges_by_windows,
    reasons_of_edges,
)
from vision.sizing.virtual_board.weighted_deviation import (
    similarity_ratio,
    trusted_windows,
    weighted_deviation,
    window_statistics,
)

Array = NDArray[np.float64]

SAMPLING_SEED = 9  # chosen: the same pair gives the same samples
AREA_SMOOTHING_WEIGHT = 0.1  # chosen: weight of a new frame in C of eq. 3.16
LEAST_WINDOWS_SHARE = 0.2  # chosen: with fewer trusted windows there is no value (`no_windows`)
FEW_WINDOWS_SHARE = 0.5  # chosen: with fewer trusted windows the reading is `few_windows`
MOST_WIDTH_DIFFERENCE_PX = 3.0  # chosen: beyond it the widths contradict the tangent model (`views_disagree`)
QUALITY_SHORTFALL_PERCENT = 2.0  # chosen: a Q_R this far below the model's on the rig is `poor_alignment`
U_PLACE_PX = 0.05  # chosen: standard uncertainty of the width when all edges lie off as a whole


class VirtualBoardGauge:
    """Measures one bar with a calibrated rig by route V; keeps the board's height and C from frame to frame.

    Parameters
    ----------
    rig : Rig
    corrections : Corrections
        `CORRECTED` or `AS_PRINTED`, or anything between.
    edges : {"forest", "sobel", "prewitt", "roberts", "canny"} or EdgeOptions
        Edge detector.
    fusion : str
        How the aligned pair is fused before windows are measured: "none", each view on its own, or a method of
        `vision.fusion.methods`, the fused picture alone.
    parameters : Parameters or None
        Numbers of algorithms 8, 9 and 13; None: those that belong to the corrections.

    Attributes
    ----------
    last_pair : AlignedPair or None
        Views, edges and board of the last pair that could be aligned, for plots.

    Raises
    ------
    ValueError
        The rig has no world frame, a camera does not see the measuring region, or an option is unknown.
    """

    def __init__(
        self,
        rig: Rig,
        *,
        corrections: Corrections = CORRECTED,
        edges: Edges = "forest",
        fusion: Fusion = "none",
        parameters: Parameters | None = None,
    ) -> None:
        if not rig.has_world:
            raise ValueError("the rig has no world frame: calibrate with the registration pictures of the low board")
        if fusion not in FUSIONS:
            raise ValueError(f"fusion: {fusion!r} is none of {', '.join(FUSIONS)}")
        self.rig = rig
        self.corrections = corrections
        self._edges = edges if isinstance(edges, EdgeOptions) else EdgeOptions(method=edges)
        usual = SERVED_PARAMETERS if corrections.robust_lines else PRINTED_PARAMETERS
        self._parameters = usual if parameters is None else parameters
        self._fusion: Fusion = fusion
        self._decoder = Decoder(rig.response)
        self.boards = VirtualBoards.of_rig(rig)
        self._step_mm = min(pixel_size_mm(camera) for camera in (rig.left, rig.right))
        self._grids = [RegionGrid(camera, rig.region_y_mm) for camera in (rig.left, rig.right)]
        self._samplers = [RegionSampler(camera, rig.region_y_mm, self._step_mm) for camera in (rig.left, rig.right)]
        self._pool = ThreadPoolExecutor(2)
        self._loop = HeightLoop()
        self.last_pair: AlignedPair | None = None
        self._uncorrupted_area = math.nan

    @property
    def _has_uncertainty(self) -> bool:
        """Whether U was shown to hold of these choices: as served, by any detector with its own numbers, unfused.

        docs/studies/virtual_board.json and, of the other detectors, route_v_uncertainty.json. A fused picture has lost
        which edge was whose, so errors of more than 10 mm occur that nothing in it shows (docs/methods/fusion.md).
        """
        usual = self._edges == EdgeOptions(method=self._edges.method)
        as_served = self.corrections == CORRECTED and self._parameters == SERVED_PARAMETERS
        return as_served and usual and self._fusion == "none"

    @property
    def carried(self) -> tuple[float, float]:
        """What the next frame gets of the earlier ones: height of the board, mm, and C of eq. 3.16; NaN before any."""
        return self._loop.height_mm, self._uncorrupted_area

    def resume(self, carried: tuple[float, float]) -> None:
        """Go on as the gauge would whose `carried` this was, so that a frame from the middle gives the same bits."""
        self._loop.height_mm, self._uncorrupted_area = carried

    def measure(self, left: SentPicture | Codes, right: SentPicture | Codes) -> VirtualBoardReading:
        """Diameter of the bar in one pair of pictures.

        Parameters
        ----------
        left, right : Picture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
            As they were sent; code values alone are grey or blue-green-red, all their bits used.

        Returns
        -------
        VirtualBoardReading
            Without a value: `no_bar` (then also `board_held`, once there was a bar), `one_camera`, `several_bars` and
            what `measure_bar` gives.

        Raises
        ------
        ValueError
            A picture is not of 8 or 16 bit, not grey or three-channel, or not of the size that the rig was calibrated
            for.
        """
        pictures = checked_pair(self.rig, left, right)
        found = [self.bars(view, picture) for view, picture in enumerate(pictures)]
        count = [len(outlines) for outlines in found]
        if min(count) == 1 == max(count):
            return self.measure_bar(*pictures, (found[0][0], found[1][0]))
        missing = Reason.ONE_CAMERA if max(count) else Reason.NO_BAR
        return VirtualBoardReading(reasons=(Reason.SEVERAL_BARS if max(count) > 1 else missing) | self._held())

    def bars(self, view: int, picture: SentPicture) -> list[Outline]:
        """Rough outlines of the bars in one view; see `RegionGrid.bars`.

        Parameters
        ----------
        view : int
            0 left, 1 right.
        picture : SentPicture
        """
        return self._grids[view].bars(picture.shown, self._decoder.shown)

    def view(self, view: int, picture: SentPicture, outline: Outline) -> tuple[Region, ViewEdges]:
        """One view, resampled, and the bar's edges in it.

        Parameters
        ----------
        view : int
            0 left, 1 right.
        picture : SentPicture
        outline : Outline
            Of the bar, roughly.
        """
        region = self._region(view, picture, outline, 0.5 * (outline.left[0] + outline.right[0]))
        return region, self._view_edges(region, outline)

    def _held(self) -> Reason:
        return Reason.BOARD_HELD if math.isfinite(self._loop.height_mm) else Reason.NONE

    def measure_bar(
        self, left: SentPicture, right: SentPicture, outlines: tuple[Outline, Outline]
    ) -> VirtualBoardReading:
        """Diameter of a bar that was found already.

        Parameters
        ----------
        left, right : Picture
        outlines : tuple of two Outline
            Where it is in each view, roughly; see `RegionGrid.bars`.

        Returns
        -------
        VirtualBoardReading
            Without a value: `edge_not_found`, `edges_clipped`, `not_aligned`, `fit_failed`, `views_disagree`,
            `implausible`, `no_windows`. With a value: `some_edges_clipped`, `low_contrast`, `poor_alignment`,
            `few_windows`, `uncertainty_unknown`.
        """
        self.last_pair = None
        images = (left, right)
        regions = self._regions(images, outlines)
        edges = list(self._pool.map(self._view_edges, regions, outlines))
        reasons = reasons_of_edges(edges)
        outline = edges[0].outline, edges[1].outline
        if reasons.forbids_value or outline[0] is None or outline[1] is None:
            return VirtualBoardReading(reasons=reasons | self._held())
        alignment = Alignment(self.rig, self.boards, *regions, self.corrections.projective_boards)
        height = self._height(alignment, outline[0], outline[1])
        if not math.isfinite(height.height_mm):
            return VirtualBoardReading(reasons=reasons | Reason.NOT_ALIGNED | self._held())
        pair = self.last_pair = AlignedPair(alignment, height, edges, outline[0])
        if self._fusion == "none":
            return unless_tilted(self.read(pair, reasons), pair)
        return unless_tilted(self._read_fused(pair, outlines[0], self._fusion, reasons), pair)

    def _read_fused(self, pair: AlignedPair, rough: Outline, method: Method, reasons: Reason) -> VirtualBoardReading:
        """Reading of the fused picture alone."""
        edges = [self._view_edges(self._fused(pair.alignment, pair.height.height_mm, method), rough)]
        reasons |= reasons_of_edges(edges)
        if reasons.forbids_value:
            return VirtualBoardReading(reasons=reasons)
        return self.read(replace(pair, edges=edges), reasons)

    def _fused(self, alignment: Alignment, height_mm: float, method: Method) -> Region:
        """Both views in one, on the pixels of the left region; luma of what was sent in luma."""
        shown = self._fused_views(alignment, height_mm, method)
        codings = [region.raw.coding for region in (alignment.left, alignment.right)]
        if {coding.samples for coding in codings} != {"luma"}:
            return resampled_region(shown, alignment.left)
        left, right = (luma_region(region) for region in (alignment.left, alignment.right))
        luma = self._fused_views(replace(alignment, left=left, right=right), height_mm, method)
        coding = replace(max(codings, key=quantiser_step), bits=8, full_range=True)
        return resampled_region(sent_picture(luma, coding, shown), alignment.left)

    def _fused_views(self, alignment: Alignment, height_mm: float, method: Method) -> NDArray[np.uint8]:
        return fuse(alignment.left.picture, alignment.right_on_left(height_mm), method, executor=self._pool)

    def _regions(
        self, images: tuple[SentPicture, SentPicture], outlines: tuple[Outline, Outline]
    ) -> tuple[Region, Region]:
        slope = float(np.mean([limb[0] for outline in outlines for limb in (outline.left, outline.right)]))
        left, right = self._pool.map(self._region, (0, 1), images, outlines, (slope, slope))
        return left, right

    def _region(self, view: int, image: SentPicture, outline: Outline, slope: float) -> Region:
        """One view with rows across a bar of this slope, or as printed with the picture's own rows."""
        if not self.corrections.turned_rows:
            return picture_region((self.rig.left, self.rig.right)[view], image, self.rig.region_y_mm)
        margin_mm = (STRIP_HALF_WIDTH_PX + FOREST_MARGIN_PX) * self._step_mm
        across = float(np.cos(np.arctan(slope)))
        reach = across * outline.left[1] - margin_mm, across * outline.right[1] + margin_mm
        return self._samplers[view].turned(image, slope, reach)

    def _view_edges(self, region: Region, outline: Outline) -> ViewEdges:
        if not self.corrections.robust_lines:
            return edges_by_windows(region, self._parameters, self._edges)
        rough = [_in_region(line, region, self.rig.region_y_mm) for line in (outline.left, outline.right)]
        decoder = self._decoder if self.corrections.half_level else None
        return edges_by_lines(region, (rough[0], rough[1]), self._parameters, self._edges, decoder)

    def _height(self, alignment: Alignment, left: BarOutline, right: BarOutline) -> Height:
        def evaluate(height_mm: float) -> Quality:
            return alignment.quality(left, right, height_mm)

        if not self.corrections.tangent_crossing:
            return search_by_overlap(evaluate, self._parameters.boards)
        middle = 0.25 * (right.first[0] + right.first[-1] + right.second[0] + right.second[-1])

        def offset_per_mm(height_mm: float) -> float:
            change, transform = alignment.parallax(height_mm), alignment.right_to_left(height_mm)
            moved = transformed(transform, middle)
            return float(moved[0] - transformed(transform / transform[2, 2] + change, middle)[0])

        return self._loop.find(evaluate, offset_per_mm, self._parameters.boards)

    def read(self, pair: AlignedPair, reasons: Reason) -> VirtualBoardReading:
        """Reading of an aligned pair: windows, their widths on the board's plane, which of them count.

        Parameters
        ----------
        pair : AlignedPair
        reasons : Reason
            Known already.
        """
        rng = np.random.default_rng(SAMPLING_SEED)
        views = range(len(pair.edges)) if self.corrections.tangent_crossing else (0,)
        width_mm = np.array([pair.sampled_widths_mm(view, self._parameters, rng) for view in views])
        sampled_mm, more = self._diameters(pair, width_mm)
        if sampled_mm is None:
            return VirtualBoardReading(reasons=reasons | more, windows_total=width_mm.shape[1])
        l_mm, sigma_mm = window_statistics(sampled_mm)
        areas = np.concatenate([pair.edges[view].areas for view in views], axis=1)
        ratio = similarity_ratio(areas, self._smoothed_area(areas[np.isfinite(l_mm)]))
        Sigma_mm = weighted_deviation(ratio, sigma_mm)
        kept = trusted_windows(Sigma_mm)
        reasons |= more | self._reasons_of_windows(l_mm, kept)
        value = {} if reasons.forbids_value else self._value(l_mm[kept], Sigma_mm[kept], pair.edges)
        if value and not self._has_uncertainty:
            reasons |= Reason.UNCERTAINTY_UNKNOWN
        return VirtualBoardReading(
            **value,
            alignment_quality=pair.height.quality.percent,
            plane_height_mm=pair.height.height_mm,
            evaluations=pair.height.evaluations,
            windows_kept=int(kept.sum()),
            windows_total=len(kept),
            window_diameters_mm=l_mm,
            window_sigmas_mm=Sigma_mm,
            window_kept=kept,
            reasons=reasons,
        )

    def _value(self, l_mm: Array, Sigma_mm: Array, edges: list[ViewEdges]) -> dict[str, float]:
        """Diameter and weighted deviation of the frame, eq. 3.19 and 3.18, and the parts of the uncertainty."""
        diameter_mm = float(l_mm.mean())
        value = {"diameter_mm": diameter_mm, "weighted_deviation_mm": float(np.median(Sigma_mm))}
        if self._has_uncertainty:
            value["u_edge_mm"] = float(l_mm.std() / np.sqrt(len(l_mm)))
            value["u_board_mm"] = diameter_mm * self.rig.square_relative_u
            value["u_light_mm"] = 2 * self._step_mm * float(np.mean([view.u_light_px for view in edges]))
            value["u_model_mm"] = U_PLACE_PX * self._step_mm
        return value

    def _smoothed_area(self, areas: Array) -> float:
        """C: median area of the frame's boundaries of interest, smoothed over frames."""
        if areas.size:
            now = max(1.0, float(np.median(areas)))
            before = self._uncorrupted_area if math.isfinite(self._uncorrupted_area) else now
            self._uncorrupted_area = before + AREA_SMOOTHING_WEIGHT * (now - before)
        return self._uncorrupted_area

    def _diameters(self, pair: AlignedPair, width_mm: Array) -> tuple[Array | None, Reason]:
        """l_it from the widths of the views, shape (windows, T), and the reasons for doubt."""
        if not self.corrections.tangent_crossing:
            return width_mm[0], Reason.NONE
        there = np.isfinite(width_mm).all(axis=(0, 2))
        if not there.any():
            return None, Reason.NO_WINDOWS
        view_mm = np.median(width_mm[:, there].mean(axis=2), axis=1)
        cameras_mm, middle_mm = pair.section_frame()
        section = solve_section(cameras_mm, pair.height.height_mm, float(view_mm.mean()), middle_mm)
        if section is None:
            return None, Reason.FIT_FAILED
        diameter_mm = 2 * section.radius_mm + section.diameter_per_width * (width_mm.mean(axis=0) - view_mm.mean())
        return diameter_mm, self._reasons_of_section(section, pair, view_mm, cameras_mm)

    def _reasons_of_section(self, section: Section, pair: AlignedPair, view_mm: Array, cameras_mm: Array) -> Reason:
        reasons = Reason.NONE
        differ_mm = (view_mm[0] - view_mm[-1]) - (section.width_mm[0] - section.width_mm[1])
        if len(view_mm) > 1 and abs(differ_mm) > MOST_WIDTH_DIFFERENCE_PX * self._step_mm:
            reasons |= Reason.VIEWS_DISAGREE
        diameter_mm = 2 * section.radius_mm
        off_mm = abs(section.height_mm - section.radius_mm)
        on_rollers = off_mm <= OFF_ROLLERS_SHARE * diameter_mm + OFF_ROLLERS_MM
        if not (DIAMETER_MM[0] <= diameter_mm <= DIAMETER_MM[1] and on_rollers):
            reasons |= Reason.IMPLAUSIBLE
        bar = np.array([section.across_mm, section.height_mm, section.radius_mm])
        cuts = tangent_cuts(cameras_mm, bar, pair.height.height_mm)
        common = max(0.0, float(cuts[:, 1].min() - cuts[:, 0].max())) / section.width_mm[0]
        if abs(pair.height.quality.percent) < 100 * common - QUALITY_SHORTFALL_PERCENT:
            reasons |= Reason.POOR_ALIGNMENT
        return reasons

    def _reasons_of_windows(self, l_mm: Array, kept: NDArray[np.bool_]) -> Reason:
        share = kept.sum() / len(kept)
        if share < LEAST_WINDOWS_SHARE:
            return Reason.NO_WINDOWS
        reasons = Reason.FEW_WINDOWS if share < FEW_WINDOWS_SHARE else Reason.NONE
        middle_mm = float(np.median(l_mm[kept]))
        return reasons if DIAMETER_MM[0] <= middle_mm <= DIAMETER_MM[1] else reasons | Reason.IMPLAUSIBLE


def _in_region(line: Array, region: Region, region_y_mm: tuple[float, float]) -> Array:
    """Slope and start of column(row) in a turned region, of a line x(y) on its plane."""
    ends_y = np.array(region_y_mm)
    world = np.column_stack([line[0] * ends_y + line[1], ends_y, np.ones(2)])
    (c0, r0), (c1, r1) = world @ region.from_world.T
    slope = (c1 - c0) / (r1 - r0)
    return np.array([slope, c0 - slope * r0])
