"""Route T: the diameter of the bar from the tangent planes of both views.

Each view shows the bar's two limbs as straight lines; every edge ray grazes the bar, so one cylinder fits them all.
There is no silhouette bias, no plane to guess, and the scatter of the points gives the covariance.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.calibration.rig import Camera, Rig
from vision.light import decoding_table
from vision.readings import Reason, SizeReading
from vision.sizing.budget import Budget, LimbLight, uncertainty_budget
from vision.sizing.cylinder import CylinderFit, fit_cylinder
from vision.sizing.limb import CLIPPED_FEW, LimbFinder, LimbPoints
from vision.sizing.points import EdgePoints
from vision.sizing.region import Outline, RegionGrid

Image = NDArray[np.uint8]
Array = NDArray[np.float64]

WINDOW_MM = 20.0  # one strip along the bar
WINDOW_AGREES_PX = 0.5  # how far the median of a window's edge points may be off on any limb
LEAST_COVERED = 0.5  # share of a limb's profiles that must give an edge
WEAK_CONTRAST = 2.0  # light of the bar over that of its background
CLIPPED_MOST = 0.5  # share of a limb's points: beyond it there is nothing left to measure
DIAMETER_MM = (40.0, 500.0)
OFF_ROLLERS_SHARE, OFF_ROLLERS_MM = 0.02, 12.0  # of the diameter, and beside it: how high a bar may bounce
WORST_LIMB_PX = 1.5  # how far the middle one of a limb's windows may be off the cylinder


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """What is prepared once for one camera."""

    camera: Camera
    grid: RegionGrid
    finder: LimbFinder

    def limbs(self, image: Image, outline: Outline) -> list[LimbPoints]:
        """Both limbs of a bar that is roughly known."""
        return [self.finder.locate(image, outline.left, -1), self.finder.locate(image, outline.right, +1)]


class TangentGauge:
    """Measures one bar with a calibrated rig by route T.

    Parameters
    ----------
    rig : Rig

    Raises
    ------
    ValueError
        The rig has no world frame, or a camera does not see the measuring region.
    """

    def __init__(self, rig: Rig) -> None:
        if not rig.has_world:
            raise ValueError("the rig has no world frame: calibrate with the registration pictures of the low board")
        self.rig = rig
        self._decode = decoding_table(rig.response)
        self._views = [
            _View(
                camera,
                RegionGrid(camera, rig.region_y_mm),
                LimbFinder(index, camera, self._decode, rig.region_y_mm),
            )
            for index, camera in enumerate((rig.left, rig.right))
        ]

    def measure(self, left: Image, right: Image) -> SizeReading:
        """Diameter of the bar in one pair of pictures.

        Parameters
        ----------
        left, right : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
            Raw pictures, grey or blue-green-red.

        Returns
        -------
        SizeReading
            Without a value: `no_bar`, `one_camera`, `several_bars`, `edge_not_found`, `edges_clipped`,
            `fit_failed`, `views_disagree`, `implausible`. With a value: `some_edges_clipped`, `low_contrast`,
            `few_windows`.

        Raises
        ------
        ValueError
            A picture is not 8 bit, not grey or three-channel, or not of the size that the rig was calibrated for.
        """
        images = (left, right)
        for name, image, view in zip(("left", "right"), images, self._views, strict=True):
            _check(name, image, view.camera)
        found = [view.grid.bars(image, self._decode) for view, image in zip(self._views, images, strict=True)]
        reasons = _reasons_of_outlines(found)
        if reasons:
            return SizeReading(reasons=reasons)
        limbs = [
            limb
            for view, image, outlines in zip(self._views, images, found, strict=True)
            for limb in view.limbs(image, outlines[0])
        ]
        reasons = _reasons_of_limbs(limbs)
        if reasons.forbids_value:
            return SizeReading(reasons=reasons)
        return self._read(limbs, reasons)

    def _read(self, limbs: list[LimbPoints], reasons: Reason) -> SizeReading:
        points = EdgePoints.of_limbs(limbs, self.rig.region_y_mm[0], WINDOW_MM)
        fit = fit_cylinder(points.rays(self.rig))
        if fit is None:
            return SizeReading(reasons=reasons | Reason.FIT_FAILED)
        total = round((self.rig.region_y_mm[1] - self.rig.region_y_mm[0]) / WINDOW_MM)
        window_px = points.window_medians(fit.residual_px, total)
        kept = int(np.count_nonzero(np.all(np.abs(window_px) <= WINDOW_AGREES_PX, axis=0)))
        reasons |= _reasons_of_fit(fit, window_px, self.rig.region_y_mm)
        if 2 * kept < total:
            reasons |= Reason.FEW_WINDOWS
        if reasons.forbids_value:
            return SizeReading(reasons=reasons, windows_kept=kept, windows_total=total)
        budget = uncertainty_budget(fit, points, total, self.rig, [_light(limb) for limb in limbs])
        return _reading(fit, budget, reasons, kept, total)


def _check(name: str, image: Image, camera: Camera) -> None:
    if image.dtype != np.uint8 or not (image.ndim == 2 or (image.ndim == 3 and image.shape[2] == 3)):
        raise ValueError(f"{name}: a uint8 picture, grey or with three channels, is needed")
    size = (image.shape[1], image.shape[0])
    if size != camera.image_size:
        raise ValueError(
            f"{name}: the picture is {size[0]} x {size[1]}, "
            f"the rig was calibrated for {camera.image_size[0]} x {camera.image_size[1]}"
        )


def _reasons_of_outlines(found: list[list[Outline]]) -> Reason:
    count = [len(outlines) for outlines in found]
    if max(count) == 0:
        return Reason.NO_BAR
    if min(count) == 0:
        return Reason.ONE_CAMERA
    return Reason.SEVERAL_BARS if max(count) > 1 else Reason.NONE


def _reasons_of_limbs(limbs: list[LimbPoints]) -> Reason:
    reasons = Reason.NONE
    for limb in limbs:
        if limb.clipped_share > CLIPPED_MOST:
            reasons |= Reason.EDGES_CLIPPED
        elif len(limb.y_mm) < LEAST_COVERED * limb.tried:
            reasons |= Reason.EDGE_NOT_FOUND
        elif np.median(limb.bright) < WEAK_CONTRAST * np.median(limb.dark):
            reasons |= Reason.LOW_CONTRAST
        if CLIPPED_FEW < limb.clipped_share <= CLIPPED_MOST:
            reasons |= Reason.SOME_EDGES_CLIPPED
    return reasons


def _reasons_of_fit(fit: CylinderFit, window_px: Array, region_y_mm: tuple[float, float]) -> Reason:
    _, z0, _, slope_z, radius_mm = fit.parameters
    reasons = Reason.NONE
    if np.abs(np.nanmedian(window_px, axis=1)).max() > WORST_LIMB_PX:
        reasons |= Reason.VIEWS_DISAGREE
    end_mm = np.abs(np.array(region_y_mm) * slope_z + z0 - radius_mm).max()
    on_rollers = end_mm <= OFF_ROLLERS_SHARE * 2 * radius_mm + OFF_ROLLERS_MM
    if not (DIAMETER_MM[0] <= 2 * radius_mm <= DIAMETER_MM[1] and on_rollers):
        reasons |= Reason.IMPLAUSIBLE
    return reasons


def _light(limb: LimbPoints) -> LimbLight:
    return LimbLight(limb.blur_px, float(np.median(limb.dark / limb.bright)), limb.clipped_share)


def _reading(fit: CylinderFit, budget: Budget, reasons: Reason, kept: int, total: int) -> SizeReading:
    x0, z0, _, _, _ = fit.parameters
    return SizeReading(
        diameter_mm=fit.diameter_mm,
        expanded_uncertainty_mm=budget.expanded_mm,
        reasons=reasons,
        windows_kept=kept,
        windows_total=total,
        axis_height_mm=float(z0),
        offset_mm=float(x0),
        u_edge_mm=budget.edge_mm,
        u_calibration_mm=budget.calibration_mm,
        u_board_mm=budget.board_mm,
        u_light_mm=budget.light_mm,
        u_shape_mm=budget.shape_mm,
        u_model_mm=budget.model_mm,
    )
