"""The mill's own cameras: what the simulated pictures are drawn with, and never what the gauge believes.

World frame: mm, z up from the roller tops z = 0, y along the rolling direction, x across.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

INVERSION_TOLERANCE = 1e-13
INVERSION_ROUNDS = 100

# What both pictures of a rig must hold: the measuring region with the largest bar in it, mm.
REGION_MM = np.array([(x, y, z) for x in (-230, 230) for y in (-270, 270) for z in (0, 300)], dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class TrueCamera:
    """A pinhole camera with a Brown-Conrady lens, pixel centres at integers.

    Attributes
    ----------
    K : ndarray of float64, shape (3, 3)
        Intrinsic matrix, pixels.
    dist : ndarray of float64, shape (5,)
        k1, k2, p1, p2, k3.
    R : ndarray of float64, shape (3, 3)
        x_camera = R x_world + t.
    t : ndarray of float64, shape (3,)
        Translation, mm.
    image_size : tuple of int
        (columns, rows), pixels.
    """

    K: Points
    dist: Points
    R: Points
    t: Points
    image_size: tuple[int, int]

    @property
    def centre_mm(self) -> Points:
        """Projection centre in the world frame, shape (3,), mm."""
        return -self.R.T @ self.t

    def project(self, points_mm: Points) -> Points:
        """Pixels (x, y) of world points, shape (..., 3) to (..., 2); NaN for points behind the camera."""
        in_camera = points_mm @ self.R.T + self.t
        depth = np.where(in_camera[..., 2:] > 0, in_camera[..., 2:], np.nan)
        distorted = _distort(in_camera[..., :2] / depth, self.dist)
        return distorted @ self.K[:2, :2].T + self.K[:2, 2]

    def rays(self, pixels: Points) -> Points:
        """Unit directions in the world frame of the light that falls on pixels, (..., 2) to (..., 3).

        Raises
        ------
        ValueError
            `pixels` lie so far outside the picture that the lens model has no inverse there.
        """
        distorted = (pixels - self.K[:2, 2]) @ np.linalg.inv(self.K[:2, :2]).T
        ideal = _undistort(distorted, self.dist)
        direction = np.concatenate([ideal, np.ones_like(ideal[..., :1])], axis=-1) @ self.R
        return direction / np.linalg.norm(direction, axis=-1, keepdims=True)

    def pixel_grid(self) -> Points:
        """All pixel centres (x, y), shape (rows, columns, 2)."""
        columns, rows = self.image_size
        return np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).astype(np.float64)

    def sees(self, points_mm: Points, margin_px: float) -> bool:
        """Whether all points lie inside the picture, `margin_px` away from its border."""
        pixels = self.project(points_mm)
        largest = np.array(self.image_size) - 1 - margin_px
        return bool(np.all((pixels >= margin_px) & (pixels <= largest)))


@dataclass(frozen=True, slots=True, eq=False)
class TrueRig:
    """Two cameras that look at the line.

    Attributes
    ----------
    left, right : TrueCamera
    region_y_mm : tuple of float
        Measuring region along the line.
    """

    left: TrueCamera
    right: TrueCamera
    region_y_mm: tuple[float, float] = (-250.0, 250.0)

    @property
    def cameras(self) -> tuple[TrueCamera, TrueCamera]:
        """Left and right camera."""
        return self.left, self.right


def default_rig(image_size: tuple[int, int] = (800, 600)) -> TrueRig:
    """Rig of the embedded mill: 3 m away, baseline 1.5 m, about 1.5 mm per pixel at 800 x 600."""
    columns, rows = image_size
    focal_px = 2.5 * columns
    left = _camera(
        focal_px=(1.001 * focal_px, 1.0015 * focal_px),
        principal_px=(0.503 * columns, 0.494 * rows),
        dist=(-0.085, 0.06, 0.0004, -0.0003, 0.0),
        pose=look_at(np.array([-765.0, -1640.0, 2450.0]), np.array([0.0, 10.0, 110.0]), np.deg2rad(1.5)),
        image_size=image_size,
    )
    right = _camera(
        focal_px=(0.998 * focal_px, 0.9985 * focal_px),
        principal_px=(0.495 * columns, 0.507 * rows),
        dist=(-0.078, 0.05, -0.0005, 0.0002, 0.0),
        pose=look_at(np.array([735.0, -1790.0, 2310.0]), np.array([0.0, -5.0, 115.0]), np.deg2rad(-2.0)),
        image_size=image_size,
    )
    return TrueRig(left, right)


def random_rig(rng: np.random.Generator, image_size: tuple[int, int] = (800, 600)) -> TrueRig:
    """Rig as another mill might have it, both pictures holding the measuring region.

    Distance 1.5 to 4 m, baseline 0.5 to 2.5 m (at most 1.2 times the distance, else the cameras would stand
    on the floor), elevation 40 to 80 degrees; each camera off its place by 3 % of the distance and aimed past
    (0, 0, 120) by 15 mm, standard deviations on each axis, and rolled by up to 12 degrees; the largest bar's region
    fills 75 to 95 % of the picture. The measuring region reaches 150 to 250 mm to either side of y = 0. Lens:
    `_random_lens`.
    """
    distance_mm = rng.uniform(1500, 4000)
    baseline_mm = rng.uniform(500, min(2500, 1.2 * distance_mm))
    elevation = np.deg2rad(rng.uniform(40, 80))
    reach_mm = np.sqrt(distance_mm**2 - baseline_mm**2 / 4)
    y_mm, z_mm = -reach_mm * np.cos(elevation), 120 + reach_mm * np.sin(elevation)
    filled = rng.uniform(0.75, 0.95)
    cameras: list[TrueCamera] = []
    for side in (-0.5, 0.5):
        centre = np.array([side * baseline_mm, y_mm, z_mm]) + rng.normal(0, 0.03 * distance_mm, 3)
        aim = np.array([0.0, 0.0, 120.0]) + rng.normal(0, 15, 3)
        pose = look_at(centre, aim, np.deg2rad(rng.uniform(-12, 12)))
        cameras.append(_random_lens(rng, pose, filled, image_size))
    return TrueRig(*cameras, region_y_mm=(-rng.uniform(150, 250), rng.uniform(150, 250)))


def nudged(camera: TrueCamera, turn_deg: tuple[float, float, float]) -> TrueCamera:
    """Camera turned about its own x, y and z axis after its calibration, its projection centre in place."""
    x, y, z = np.deg2rad(turn_deg)
    angle = math.hypot(x, y, z)
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    # Rodrigues' formula
    turn = np.eye(3) + np.sinc(angle / np.pi) * skew + 0.5 * np.sinc(angle / 2 / np.pi) ** 2 * skew @ skew
    return replace(camera, R=turn @ camera.R, t=turn @ camera.t)


def look_at(centre_mm: Points, aim_mm: Points, roll: float) -> tuple[Points, Points]:
    """Pose (R, t) of a camera at `centre_mm` that looks at `aim_mm`, turned by `roll` about its axis, rad."""
    forward = (aim_mm - centre_mm) / np.linalg.norm(aim_mm - centre_mm)
    level = np.array([forward[1], -forward[0], 0.0]) / np.hypot(forward[0], forward[1])
    down = np.cross(forward, level)
    x_axis = math.cos(roll) * level + math.sin(roll) * down
    R = np.array([x_axis, np.cross(forward, x_axis), forward], dtype=np.float64)
    return R, -R @ centre_mm


def _camera(
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    dist: tuple[float, ...],
    pose: tuple[Points, Points],
    image_size: tuple[int, int],
) -> TrueCamera:
    K = np.array([[focal_px[0], 0, principal_px[0]], [0, focal_px[1], principal_px[1]], [0, 0, 1.0]])
    return TrueCamera(K, np.array(dist), *pose, image_size)


def _random_lens(
    rng: np.random.Generator, pose: tuple[Points, Points], filled: float, image_size: tuple[int, int]
) -> TrueCamera:
    """Camera whose focal length lets the measuring region fill a part of the picture.

    Pixels are square to 0.2 %, the principal point lies within 1 % of the picture's width from its middle; k1 is -0.12
    to 0.03, k2 -0.05 to 0.08, p1 and p2 up to 0.0008, k3 up to 0.02.
    """
    columns, rows = image_size
    half_size = np.array([columns, rows]) / 2
    in_camera = REGION_MM @ pose[0].T + pose[1]
    focal_px = filled * np.min(half_size / np.abs(in_camera[:, :2] / in_camera[:, 2:]))
    focal_y_px = focal_px * rng.uniform(0.998, 1.002)
    principal = half_size - 0.5 + rng.uniform(-0.01, 0.01, 2) * columns
    dist = (
        rng.uniform(-0.12, 0.03),
        rng.uniform(-0.05, 0.08),
        rng.uniform(-0.0008, 0.0008),
        rng.uniform(-0.0008, 0.0008),
        rng.uniform(-0.02, 0.02),
    )
    return _camera((focal_px, focal_y_px), (principal[0], principal[1]), dist, pose, image_size)


def _distort(ideal: Points, dist: Points) -> Points:
    """Brown-Conrady: points (x, y) on the plane z = 1 as the lens moves them."""
    radial, tangential = _lens_terms(ideal, dist)
    return ideal * radial + tangential


def _undistort(distorted: Points, dist: Points) -> Points:
    """Inverse of `_distort` by fixed-point iteration down to rounding."""
    ideal = distorted
    for _ in range(INVERSION_ROUNDS):
        radial, tangential = _lens_terms(ideal, dist)
        previous, ideal = ideal, (distorted - tangential) / radial
        if np.max(np.abs(ideal - previous), initial=0.0) < INVERSION_TOLERANCE:
            return ideal
    raise ValueError("pixels: too far outside the picture, the lens model has no inverse there")


def _lens_terms(ideal: Points, dist: Points) -> tuple[Points, Points]:
    k1, k2, p1, p2, k3 = dist
    x, y = ideal[..., 0], ideal[..., 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    along_x = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    along_y = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return radial[..., None], np.stack([along_x, along_y], axis=-1)
