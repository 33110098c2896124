"""Joint adjustment of two cameras and all boards they saw: least squares on every corner at once."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.geometry.camera import CAMERA_PARAMETERS, Camera, rotation
from vision.geometry.lens import distort_slope

N_CAMERA = len(CAMERA_PARAMETERS)
N_RIG = 2 * N_CAMERA
N_BOARD = 6  # omega_x, omega_y, omega_z, t_x, t_y, t_z
K3 = CAMERA_PARAMETERS.index("k3")
POSE = slice(CAMERA_PARAMETERS.index("omega_x"), N_CAMERA)


@dataclass(frozen=True, slots=True, eq=False)
class Sights:
    """Corners that one camera saw.

    Attributes
    ----------
    boards : ndarray of int, shape (pictures,)
        Which board pose each picture shows.
    corners_px : ndarray of float64, shape (pictures, corners, 2)
        (x, y), pixels, in the order of `Board.corners_mm`.
    """

    boards: NDArray[np.intp]
    corners_px: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Two cameras and the boards before them, all in one world frame.

    Attributes
    ----------
    cameras : tuple of Camera
        Left, right.
    R : ndarray of float64, shape (boards, 3, 3)
    t : ndarray of float64, shape (boards, 3)
        Board to world: x_world = R x_board + t, mm.
    """

    cameras: tuple[Camera, Camera]
    R: NDArray[np.float64]
    t: NDArray[np.float64]

    def moved(self, delta: NDArray[np.float64]) -> "Scene":
        """Return the scene after small changes: 15 of each camera, then 6 (omega, t) of each board."""
        changes = delta[N_RIG:].reshape(-1, N_BOARD)
        turns = np.array([rotation(change[:3]) for change in changes])
        left, right = self.cameras
        return Scene(
            cameras=(left.perturbed(delta[:N_CAMERA]), right.perturbed(delta[N_CAMERA:N_RIG])),
            R=turns @ self.R,
            t=self.t + changes[:, 3:],
        )


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Corners, free parameters and known height of an adjustment.

    Attributes
    ----------
    corners_mm : ndarray of float64, shape (corners, 3)
        Corners on the board.
    sights : tuple of Sights
        Of the left camera, of the right one.
    free : ndarray of bool, shape (30 + 6 boards,)
        Which parameters are adjusted, in the order of `Scene.moved`.
    known_height : tuple of (int, float, float) or None
        Board whose t_z is known: its index, height and standard uncertainty, mm.
    """

    corners_mm: NDArray[np.float64]
    sights: tuple[Sights, Sights]
    free: NDArray[np.bool_]
    known_height: tuple[int, float, float] | None


@dataclass(frozen=True, slots=True, eq=False)
class Adjusted:
    """Result of `adjust`.

    Attributes
    ----------
    scene : Scene
        At the least sum of squares.
    covariance : ndarray of float64, shape (30 + 6 boards, 30 + 6 boards)
        sigma^2 (J'J)^-1, zero where a parameter was not adjusted.
    noise_px : float
        Standard deviation of a corner's coordinate, from the residuals and the degrees of freedom.
    residual_px : float
        Root mean square of the residuals, per coordinate.
    errors_px : tuple of ndarray of float64, each of shape (pictures, corners, 2)
        Residuals, corners minus their projections, of the left camera's pictures and of the right one's.
    """

    scene: Scene
    covariance: NDArray[np.float64]
    noise_px: float
    residual_px: float
    errors_px: tuple[NDArray[np.float64], NDArray[np.float64]]


class _Normal(NamedTuple):
    """Normal equations of the free parameters: J'J, J'r and r'r, in pixels."""

    matrix: NDArray[np.float64]
    gradient: NDArray[np.float64]
    cost: float


def adjust(scene: Scene, problem: Problem) -> Adjusted:
    """Adjust all free parameters to all corners by Levenberg's and Marquardt's method.

    The weight of a known height against the corners follows from the corners' noise, so the noise is estimated
    from a first fit and the fit is repeated with it.

    Parameters
    ----------
    scene : Scene
        Start, near the solution.
    problem : Problem

    Returns
    -------
    Adjusted
    """
    noise_px = 0.05
    equations = sum(sights.corners_px.size for sights in problem.sights) + (problem.known_height is not None)
    for _ in range(3 if problem.known_height else 1):
        scene, normal = _minimise(scene, problem, noise_px)
        noise_px = float(np.sqrt(normal.cost / max(equations - len(normal.gradient), 1)))
    normal = _normal_equations(scene, problem, noise_px)
    covariance = np.zeros((len(problem.free), len(problem.free)))
    covariance[np.ix_(problem.free, problem.free)] = noise_px**2 * _inverse(normal.matrix)
    errors = (_errors(scene, problem, 0), _errors(scene, problem, 1))
    return Adjusted(
        scene=scene,
        covariance=covariance,
        noise_px=noise_px,
        residual_px=float(np.sqrt(np.mean(np.concatenate([e.ravel() for e in errors]) ** 2))),
        errors_px=errors,
    )


def project_with_slopes(
    camera: Camera, points_mm: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Project world points, with derivatives.

    Parameters
    ----------
    camera : Camera
    points_mm : ndarray of float64, shape (n, 3)
        World points, mm.

    Returns
    -------
    points_px : ndarray of float64, shape (n, 2)
    by_camera : ndarray of float64, shape (n, 2, 15)
        Derivative by the changes of `Camera.perturbed`.
    by_point : ndarray of float64, shape (n, 2, 3)
        Derivative by the world point.
    """
    turned = points_mm @ camera.R.T
    X = turned + camera.t
    ideal = X[:, :2] / X[:, 2:]
    points_px = camera.pixels(ideal)
    f = camera.K[[0, 1], [0, 1]]

    by_ideal = f[:, None] * distort_slope(ideal, camera.dist)
    by_X = np.concatenate([by_ideal, -by_ideal @ ideal[:, :, None]], axis=2) / X[:, 2, None, None]

    by_camera = np.zeros((len(X), 2, N_CAMERA))
    by_camera[:, [0, 1], [0, 1]] = (points_px - camera.K[:2, 2]) / f
    by_camera[:, [0, 1], [2, 3]] = 1.0
    by_camera[:, :, 4:9] = f[:, None] * _distort_by_coefficients(ideal)
    by_camera[:, :, 9:12] = by_X @ -_cross_matrices(turned)
    by_camera[:, :, 12:] = by_X
    return points_px, by_camera, by_X @ camera.R


def _distort_by_coefficients(ideal: NDArray[np.float64]) -> NDArray[np.float64]:
    x, y = ideal[:, 0], ideal[:, 1]
    r2 = x * x + y * y
    slope = np.empty((len(x), 2, 5))
    for row, (along, across) in enumerate([(x, y), (y, x)]):
        slope[:, row, 0] = along * r2
        slope[:, row, 1] = along * r2**2
        slope[:, row, 2 + row] = 2.0 * along * across
        slope[:, row, 3 - row] = r2 + 2.0 * along * along
        slope[:, row, 4] = along * r2**3
    return slope


def _cross_matrices(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    matrices = np.zeros((len(vectors), 3, 3))
    matrices[:, [2, 0, 1], [1, 2, 0]] = vectors
    matrices[:, [1, 2, 0], [2, 0, 1]] = -vectors
    return matrices


def _errors(scene: Scene, problem: Problem, which: int) -> NDArray[np.float64]:
    """Measured minus projected corners of one camera, shape (pictures, corners, 2)."""
    sights = problem.sights[which]
    points = problem.corners_mm @ scene.R[sights.boards].transpose(0, 2, 1) + scene.t[sights.boards, None]
    projected = scene.cameras[which].project(points.reshape(-1, 3))
    return sights.corners_px - projected.reshape(sights.corners_px.shape)


def _normal_equations(scene: Scene, problem: Problem, noise_px: float) -> _Normal:
    size = len(problem.free)
    matrix, gradient, cost = np.zeros((size, size)), np.zeros(size), 0.0
    for which in (0, 1):
        residuals, slopes, columns = _picture_equations(scene, problem, which)
        # Picture by picture, so that no product is large enough for a BLAS to spread over busy-waiting threads.
        np.add.at(matrix, (columns[:, :, None], columns[:, None, :]), slopes.transpose(0, 2, 1) @ slopes)
        np.add.at(gradient, columns, (residuals[:, None] @ slopes)[:, 0])
        cost += float(np.sum(residuals**2))
    if problem.known_height:
        board, height_mm, u_mm = problem.known_height
        column, weight = N_RIG + N_BOARD * board + 5, noise_px / u_mm
        residual = weight * (height_mm - scene.t[board, 2])
        matrix[column, column] += weight**2
        gradient[column] += weight * residual
        cost += residual**2
    free = problem.free
    return _Normal(matrix[np.ix_(free, free)], gradient[free], cost)


def _picture_equations(
    scene: Scene, problem: Problem, which: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.intp]]:
    """Equations of one camera's pictures.

    Returns
    -------
    residuals : ndarray of float64, shape (pictures, 2 corners)
        Measured minus modelled, pixels.
    slopes : ndarray of float64, shape (pictures, 2 corners, 21)
        The model's derivative by the camera's and the board's changes.
    columns : ndarray of int, shape (pictures, 21)
        Where those 21 stand among all parameters.
    """
    sights = problem.sights[which]
    pictures, corners = sights.corners_px.shape[:2]
    turned = problem.corners_mm @ scene.R[sights.boards].transpose(0, 2, 1)
    points = (turned + scene.t[sights.boards, None]).reshape(-1, 3)
    projected, by_camera, by_point = project_with_slopes(scene.cameras[which], points)
    by_turn = by_point @ -_cross_matrices(turned.reshape(-1, 3))
    slopes = np.concatenate([by_camera, by_turn, by_point], axis=2).reshape(pictures, 2 * corners, -1)
    residuals = (sights.corners_px.reshape(-1, 2) - projected).reshape(pictures, 2 * corners)
    of_camera = np.tile(which * N_CAMERA + np.arange(N_CAMERA), (pictures, 1))
    of_board = N_RIG + N_BOARD * sights.boards[:, None] + np.arange(N_BOARD)
    return residuals, slopes, np.concatenate([of_camera, of_board], axis=1)


def _minimise(scene: Scene, problem: Problem, noise_px: float) -> tuple[Scene, _Normal]:
    damping = 1e-3
    normal = _normal_equations(scene, problem, noise_px)
    for _ in range(100):
        trial = scene.moved(_step(normal, problem.free, damping))
        trial_normal = _normal_equations(trial, problem, noise_px)
        gain = normal.cost - trial_normal.cost
        done = abs(gain) <= 1e-10 * normal.cost
        if gain > 0.0:
            scene, normal = trial, trial_normal
            damping = max(damping / 10.0, 1e-12)
        else:
            damping = 10.0 * damping
        if done or damping > 1e6:
            break
    return scene, normal


def _step(normal: _Normal, free: NDArray[np.bool_], damping: float) -> NDArray[np.float64]:
    matrix, scale = _scaled(normal.matrix)
    matrix[np.diag_indices_from(matrix)] += damping
    delta = np.zeros(len(free))
    delta[free] = scale * np.linalg.solve(matrix, scale * normal.gradient)
    return delta


def _inverse(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """(J'J)^-1; the pseudo-inverse would hide what the pictures leave open."""
    scaled, scale = _scaled(matrix)
    return scale[:, None] * np.linalg.inv(scaled) * scale


def _scaled(matrix: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """J'J with a diagonal of ones, and the scale of each parameter that makes it so."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    return matrix * np.outer(scale, scale), scale
