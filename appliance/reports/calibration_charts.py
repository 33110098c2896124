"""Charts of a calibration as SVG, told apart without colour: they are printed."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.reports.charts import new_figure, svg_of
from vision.calibration.acceptance import COVERED_LEAST, covered_share
from vision.calibration.initial_guess import HIGH, LOW
from vision.calibration.response import MeasuredResponse
from vision.calibration.rig import SIDES, Rig
from vision.calibration.stability import Stability
from vision.calibration.stereo import Calibration, Picture
from vision.light import NAMED_RESPONSES, light_of

ARROW_SHARE = 0.04  # of the picture's width, for a residual of the root mean square
_BLUE, _RED, _GREY = "#1f4e79", "#b00020", "#808080"
_BOARDS = {LOW: ("s", _RED, "low board"), HIGH: ("^", "black", "high board")}

Array = NDArray[np.float64]


def coverage(calibration: Calibration) -> str:
    """Where in both pictures the boards' corners were, and the hull around them."""
    figure, axes = new_figure(2.5, 1, 2)
    for side, one in enumerate(axes):
        pictures = _of_side(calibration, side)
        points = _joined([picture.corners_px for picture in pictures])
        size = (calibration.rig.left, calibration.rig.right)[side].image_size
        poses = _joined([picture.corners_px for picture in pictures if picture.board not in _BOARDS])
        one.plot(*poses.T, ".", color=_BLUE, markersize=2, label="poses")
        for picture in pictures:
            if picture.board in _BOARDS:
                marker, colour, label = _BOARDS[picture.board]
                one.plot(*picture.corners_px.T, marker, color=colour, markersize=3, fillstyle="none", label=label)
        hull = cv2.convexHull(points.astype(np.float32))[:, 0]
        one.plot(*np.vstack([hull, hull[:1]]).T, color=_GREY, linewidth=1, label="covered")
        share = 100 * covered_share(points, size)
        _frame(one, size, f"{SIDES[side]} picture: {share:.0f} % covered, {100 * COVERED_LEAST:.0f} % are wanted")
    _legend_below(figure, axes[0])
    return svg_of(figure)


def residuals(calibration: Calibration) -> str:
    """Residual of each corner as an arrow, many times its length."""
    figure, axes = new_figure(2.5, 1, 2)
    rig = calibration.rig
    for side, one in enumerate(axes):
        pictures = _of_side(calibration, side)
        points = _joined([picture.corners_px for picture in pictures])
        errors = _joined([picture.errors_px for picture in pictures])
        size = (rig.left, rig.right)[side].image_size
        rms_px = float(np.sqrt(np.mean(errors**2)))
        magnified = ARROW_SHARE * size[0] / max(rig.residual_px, 1e-9)
        arrows = one.quiver(
            *points.T, *errors.T, angles="xy", scale_units="xy", scale=1 / magnified, width=0.0015, color=_BLUE
        )
        one.quiverkey(arrows, 0.8, 1.06, 0.1, "0.1 px", labelpos="E", fontproperties={"size": 8})
        _frame(one, size, f"{SIDES[side]} camera: {rms_px:.3f} px")
    return svg_of(figure)


def stability(found: Stability) -> str:
    """Change of each quantity without each pose, against its stated uncertainty."""
    figure, axes = new_figure(1.1 * len(found.quantities) + 0.5, len(found.quantities), 1)
    places = np.arange(len(found.poses))
    for one, quantity in zip(axes, found.quantities, strict=True):
        one.axhspan(-quantity.u, quantity.u, color="#d9d9d9", label="stated u")
        one.axhline(0, color="black", linewidth=0.5)
        one.plot(places, quantity.changes, "o", color=_BLUE, markersize=4, label="without this pose")
        one.set_title(f"{quantity.name}: change, {quantity.unit}", loc="left")
        one.margins(y=0.15)
    axes[-1].set_xticks(places, found.poses)
    axes[-1].set_xlabel("pose that is left out")
    _legend_below(figure, axes[0])
    return svg_of(figure)


def response(rig: Rig, measured: MeasuredResponse) -> str:
    """Light over the pictures' code values, as the board pictures have it, with its U, and of the standards."""
    figure, (one,) = new_figure(2.6, 1, 1)
    codes = np.linspace(0.0, 1.0, 201)
    curve = measured.curve
    light, u = light_of(codes, curve), curve_u(measured, codes)
    one.fill_between(100 * codes, 100 * (light - 2 * u), 100 * (light + 2 * u), color="#c9d8e8", label="its U (k = 2)")
    one.plot(100 * codes, 100 * light, color=_BLUE, linewidth=1.6, label="measured from the boards")
    for name, line in zip(NAMED_RESPONSES, (":", "--", "-."), strict=False):
        used = ", used by the gauge" if rig.response == name else ""
        one.plot(100 * codes, 100 * light_of(codes, name), line, color="black", linewidth=0.9, label=f"{name}{used}")
    one.set_xlabel("code value, % of the largest")
    one.set_ylabel("light, % of the largest")
    one.set_xlim(0, 100)
    one.set_ylim(0, 100)
    one.legend(loc="upper left", frameon=False)
    return svg_of(figure)


def curve_u(measured: MeasuredResponse, codes: Array) -> Array:
    """Standard uncertainty of the light at code values, from the curve's covariance.

    Parameters
    ----------
    measured : MeasuredResponse
    codes : ndarray of float64, shape (n,)
        0 to 1.
    """
    curve = measured.curve
    steps = np.sqrt(np.diag(curve.covariance))
    slopes = np.zeros((len(codes), len(steps)))
    for index in np.flatnonzero(steps):
        step = np.zeros(len(steps))
        step[index] = 1e-3 * steps[index]
        up, down = (type(curve)(*(curve.parameters + sign * step)) for sign in (1, -1))
        slopes[:, index] = (light_of(codes, up) - light_of(codes, down)) / (2 * step[index])
    return np.sqrt(np.einsum("ni,ij,nj->n", slopes, curve.covariance, slopes))


def _of_side(calibration: Calibration, side: int) -> list[Picture]:
    return [picture for picture in calibration.pictures if picture.side == side]


def _joined(parts: list[Array]) -> Array:
    return np.concatenate(parts) if parts else np.empty((0, 2))


def _frame(axes: Any, size: tuple[int, int], title: str) -> None:
    axes.set_xlim(-0.5, size[0] - 0.5)
    axes.set_ylim(size[1] - 0.5, -0.5)
    axes.set_aspect("equal")
    axes.set_title(title, loc="left")
    axes.set_xlabel("column, px")
    axes.set_ylabel("row, px")
    for spine in axes.spines.values():
        spine.set_visible(True)


def _legend_below(figure: Any, axes: Any) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
