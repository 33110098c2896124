"""How much a calibration hangs on each board: the same calibration again, with one pose left out.

The changes are also a check of the stated uncertainties that knows nothing of how these were computed: the jackknife
estimate of a standard error, u = sqrt((n - 1) / n sum (x_i - mean x)^2) (B. Efron and R. J. Tibshirani, An
Introduction to the Bootstrap, 1993, eq. 11.5).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.calibration.acceptance import CalibrationError
from vision.calibration.checkerboard import Board
from vision.calibration.initial_guess import HIGH, LOW
from vision.calibration.rig import Rig
from vision.calibration.stereo import Calibration, Pair, calibrate

LENGTH_MM = 100.0  # of the length across the line whose change is stated


class Quantity(NamedTuple):
    """A quantity of a rig, and what leaving out each pose changes.

    Attributes
    ----------
    name, unit : str
    value, u : float
        With all poses, and its standard uncertainty as the calibration states it, without the board's scale.
    changes : ndarray of float64, shape (poses,)
        Value without a pose, less `value`; NaN where the calibration is refused without it.
    """

    name: str
    unit: str
    value: float
    u: float
    changes: NDArray[np.float64]

    @property
    def jackknife_u(self) -> float:
        """Standard uncertainty from the changes alone; NaN with fewer than two of them."""
        changes = self.changes[np.isfinite(self.changes)]
        if len(changes) < 2:
            return float("nan")
        return float(np.sqrt((len(changes) - 1) * np.var(changes)))

    @property
    def largest(self) -> int | None:
        """Place of the pose without which it changes most; None where none can be left out."""
        if not np.isfinite(self.changes).any():
            return None
        return int(np.nanargmax(np.abs(self.changes)))


class Stability(NamedTuple):
    """What leaving out each pose changes.

    Attributes
    ----------
    poses : tuple of str
        Names of the poses left out, one at a time; the registration boards are never left out.
    quantities : tuple of Quantity
    refusals : dict of str to str
        Why the calibration is refused without a pose, by its name.
    """

    poses: tuple[str, ...]
    quantities: tuple[Quantity, ...]
    refusals: dict[str, str]


def leave_one_out(
    calibration: Calibration, board: Board, progress: Callable[[int, int], object] | None = None
) -> Stability:
    """Calibrate again without each of the poses that a calibration uses.

    Parameters
    ----------
    calibration : Calibration
    board : Board
        That it was made with.
    progress : callable, optional
        Called with the number of poses done and of all.
    """
    rig = calibration.rig
    pairs = _pairs(calibration)
    missing: Pair = (None, None)
    poses = [name for name in pairs if name not in (LOW, HIGH)]
    rigs: list[Rig | None] = []
    refusals: dict[str, str] = {}
    for done, out in enumerate(poses, 1):
        others = [name for name in poses if name != out]
        try:
            again = calibrate(
                [pairs[name] for name in others],
                pairs.get(LOW, missing),
                pairs.get(HIGH, missing),
                board,
                rig.left.image_size,
                names=others,
                region_y_mm=rig.region_y_mm,
            )
            rigs.append(again.rig)
        except CalibrationError as error:
            rigs.append(None)
            refusals[out] = "; ".join(error.reasons)
        if progress is not None:
            progress(done, len(poses))
    quantities = tuple(_quantity(name, unit, of, rig, rigs) for name, unit, of in _quantities(rig))
    return Stability(tuple(poses), quantities, refusals)


def _quantity(name: str, unit: str, of: Callable[[Rig], float], rig: Rig, rigs: list[Rig | None]) -> Quantity:
    value = of(rig)
    changes = np.array([np.nan if one is None else of(one) - value for one in rigs], dtype=np.float64)
    return Quantity(name, unit, value, rig.standard_uncertainty(of), changes)


def _quantities(rig: Rig) -> list[tuple[str, str, Callable[[Rig], float]]]:
    found: list[tuple[str, str, Callable[[Rig], float]]] = [
        ("left focal length", "px", lambda rig: float(rig.left.K[0, 0])),
        ("right focal length", "px", lambda rig: float(rig.right.K[0, 0])),
        ("distance of the cameras", "mm", lambda rig: rig.baseline_mm),
    ]
    if rig.has_world:
        y_mm, z_mm = float(np.mean(rig.region_y_mm)), (rig.low_mm + rig.high_mm) / 2
        ends_mm = np.array([[-LENGTH_MM / 2, y_mm, z_mm], [LENGTH_MM / 2, y_mm, z_mm]])
        left_px, right_px = rig.left.project(ends_mm), rig.right.project(ends_mm)
        found.append((f"{LENGTH_MM:g} mm across the line", "mm", lambda rig: _length_mm(rig, left_px, right_px)))
    return found


def _length_mm(rig: Rig, left_px: NDArray[np.float64], right_px: NDArray[np.float64]) -> float:
    """Distance of two points seen by both cameras: the middle of the shortest way between both rays of each."""
    first, second = (
        _nearest_mm(rig, left, right)
        for left, right in zip(rig.left.rays(left_px), rig.right.rays(right_px), strict=True)
    )
    return float(np.linalg.norm(second - first))


def _nearest_mm(rig: Rig, left: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    centres = rig.left.centre_mm, rig.right.centre_mm
    away = np.linalg.lstsq(np.column_stack([left, -right]), centres[1] - centres[0], rcond=None)[0]
    return (centres[0] + away[0] * left + centres[1] + away[1] * right) / 2


def _pairs(calibration: Calibration) -> dict[str, Pair]:
    """Corners that a calibration uses, by pose."""
    sides: tuple[dict[str, NDArray[np.float64]], ...] = ({}, {})
    for picture in calibration.pictures:
        sides[picture.side][picture.board] = picture.corners_px
    left, right = sides
    return {name: (left.get(name), right.get(name)) for name in sorted(left | right)}
