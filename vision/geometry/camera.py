"""A calibrated camera: world points to pixels and pixels to rays."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry.lens import distort, undistort

# Parameters of one camera, in the order of `Camera.perturbed` and of `Rig.covariance`.
CAMERA_PARAMETERS = (
    *("fx", "fy", "cx", "cy"),
    *("k1", "k2", "p1", "p2", "k3"),
    *("omega_x", "omega_y", "omega_z"),
    *("t_x", "t_y", "t_z"),
)


def rotation(omega: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation matrix Exp([omega]x) of a rotation vector in radians."""
    return np.asarray(cv2.Rodrigues(omega)[0], dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A pinhole camera with lens distortion, OpenCV's model; pixel centres at integers.

    Attributes
    ----------
    K : ndarray of float64, shape (3, 3)
        Intrinsic matrix, pixels.
    dist : ndarray of float64, shape (5,)
        k1, k2, p1, p2, k3.
    R : ndarray of float64, shape (3, 3)
        Rotation from world to camera: x_camera = R x_world + t.
    t : ndarray of float64, shape (3,)
        Translation, mm.
    image_size : tuple of int
        (columns, rows), pixels.
    """

    K: NDArray[np.float64]
    dist: NDArray[np.float64]
    R: NDArray[np.float64]
    t: NDArray[np.float64]
    image_size: tuple[int, int]

    @property
    def centre_mm(self) -> NDArray[np.float64]:
        """Projection centre in the world frame, shape (3,), mm: C = -R' t."""
        return -self.R.T @ self.t

    def project(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where world points appear in the picture.

        Parameters
        ----------
        points_mm : ndarray of float64, shape (n, 3)
            World points, mm.

        Returns
        -------
        ndarray of float64, shape (n, 2)
            (x, y), pixels; NaN for points that are not in front of the camera.
        """
        X = points_mm @ self.R.T + self.t
        z = np.where(X[:, 2:] > 0.0, X[:, 2:], np.nan)
        return self.pixels(X[:, :2] / z)

    def pixels(self, normalised: NDArray[np.float64]) -> NDArray[np.float64]:
        """Pixels (x, y), shape (n, 2), of ideal points (x/z, y/z) on the plane z = 1 of the camera, shape (n, 2)."""
        return distort(normalised, self.dist) * self.K[[0, 1], [0, 1]] + self.K[:2, 2]

    def undistort(self, points_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Ideal points (x/z, y/z) on the plane z = 1 of the camera that appear at given pixels.

        Parameters
        ----------
        points_px : ndarray of float64, shape (n, 2)
            (x, y), pixels.

        Returns
        -------
        ndarray of float64, shape (n, 2)
            Exact to 1e-12; NaN where no point of the lens model's monotonic part appears at the pixel.
        """
        return undistort((points_px - self.K[:2, 2]) / self.K[[0, 1], [0, 1]], self.dist)

    def rays(self, points_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Unit directions, in the world frame, of what appears at given pixels.

        Parameters
        ----------
        points_px : ndarray of float64, shape (n, 2)
            (x, y), pixels.

        Returns
        -------
        ndarray of float64, shape (n, 3)
            From the camera's centre outwards; NaN where `undistort` is NaN.
        """
        directions = np.column_stack([self.undistort(points_px), np.ones(len(points_px))]) @ self.R
        return directions / np.linalg.norm(directions, axis=1, keepdims=True)

    def perturbed(self, delta: NDArray[np.float64]) -> "Camera":
        """Return the camera after small changes of its parameters.

        Parameters
        ----------
        delta : ndarray of float64, shape (15,)
            In the order of `CAMERA_PARAMETERS`: added to fx, fy, cx, cy (pixels), k1, k2, p1, p2, k3 and t (mm);
            the rotation becomes Exp([omega]x) R, omega in radians.

        Returns
        -------
        Camera
        """
        fx, fy, cx, cy = delta[:4]
        return replace(
            self,
            K=self.K + np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 0.0]]),
            dist=self.dist + delta[4:9],
            R=rotation(delta[9:12]) @ self.R,
            t=self.t + delta[12:15],
        )

    def turned(self, omega: NDArray[np.float64]) -> "Camera":
        """Return the camera turned about its own projection centre by a rotation vector, radians, in its own axes."""
        turn = rotation(omega)
        return replace(self, R=turn @ self.R, t=turn @ self.t)
