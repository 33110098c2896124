"""Rigs and boards with known truth; the projection is OpenCV's, not the product's."""

from dataclasses import dataclass

import cv2
import numpy as np

from vision.calibration.checkerboard import Board

IMAGE_SIZE = (1600, 1200)
BOARD = Board((8, 5), 50.0, 0.0, 200.0, 0.01, 0.1, "gamma 2.2")


@dataclass(frozen=True)
class TrueCamera:
    K: np.ndarray
    dist: np.ndarray
    R: np.ndarray
    t: np.ndarray

    @property
    def centre(self):
        return -self.R.T @ self.t

    def see(self, points):
        pixels, _ = cv2.projectPoints(points, cv2.Rodrigues(self.R)[0], self.t, self.K, self.dist)
        return pixels[:, 0]


def look_at(position, target, roll):
    """Rotation of a camera at `position` that looks at `target`, with x to the right of the world's x."""
    z = (target - position) / np.linalg.norm(target - position)
    x = np.cross(np.array([0.0, -1.0, -1.0]), z)
    x /= np.linalg.norm(x)
    upright = np.array([x, np.cross(z, x), z])
    return cv2.Rodrigues(np.array([0.0, 0.0, roll]))[0] @ upright


def random_cameras(rng, k3=0.0):
    distance, baseline = rng.uniform(1500.0, 3500.0), rng.uniform(0.35, 0.7)
    focal = rng.uniform(1500.0, 2200.0)
    cameras = []
    for sign in (-1.0, 1.0):
        position = distance * np.array([sign * baseline / 2.0, rng.uniform(-0.7, -0.3), rng.uniform(0.7, 0.9)])
        R = look_at(position, rng.normal(0.0, 30.0, 3), rng.normal(0.0, 0.05))
        K = np.array(
            [
                [focal * rng.normal(1.0, 0.003), 0.0, 799.5 + rng.normal(0.0, 15.0)],
                [0.0, focal * rng.normal(1.0, 0.003), 599.5 + rng.normal(0.0, 15.0)],
                [0.0, 0.0, 1.0],
            ]
        )
        dist = np.array([rng.normal(-0.05, 0.05), rng.normal(0.02, 0.02), *rng.normal(0.0, 5e-4, 2), k3])
        cameras.append(TrueCamera(K, dist, R, -R @ position))
    return cameras


def inside(pixels):
    return bool((pixels > 15.0).all() and (pixels < np.array(IMAGE_SIZE) - 15.0).all())


def random_poses(rng, cameras, count=15):
    """Corners in the world of boards that both cameras see whole, tilted up to 40 degrees, shape (n, 3) each."""
    towards = sum(camera.centre for camera in cameras) / 2.0
    reach = 0.16 * float(np.linalg.norm(towards))
    poses = []
    while len(poses) < count:
        turn = cv2.Rodrigues(rng.normal(0.0, 0.35, 3))[0]
        centre = rng.normal(0.0, 1.5 * reach, 3) + np.array([0.0, 0.0, reach])
        points = BOARD.corners_mm @ turn.T + centre
        if all(inside(camera.see(points)) for camera in cameras):
            poses.append(points)
    return poses


def observe(rng, cameras, points, noise_px):
    left, right = (camera.see(points) + rng.normal(0.0, noise_px, (len(points), 2)) for camera in cameras)
    return left, right


def flat_board(height, x=0.0, y=0.0, yaw=0.0):
    turn = cv2.Rodrigues(np.array([0.0, 0.0, yaw]))[0]
    return BOARD.corners_mm @ turn.T + [x, y, height]
