"""The horizontal plane on which both sizing routes resample the measuring region."""

import numpy as np

from vision.geometry.camera import Camera

PLANE_HEIGHT_MM = 100.0  # chosen: between the axis heights of the smallest bar (20 mm) and of the largest (250 mm)
FOLD_MARGIN = 1.05  # chosen: ideal radii up to 5 % beyond the picture's corners still belong to the picture


def pixel_size_mm(camera: Camera) -> float:
    """Length on the measuring plane, across the camera's view, that one pixel at the world's origin shows, mm."""
    depth_mm = abs(camera.R[2] @ np.array([0.0, 0.0, PLANE_HEIGHT_MM]) + camera.t[2])
    return float(depth_mm / camera.K[0, 0])


def farthest_ideal_radius(camera: Camera) -> float:
    """Largest distance of an ideal point (x/z, y/z) from the camera's axis that the picture shows.

    Boards fix a lens model in the middle of the picture only: beyond this radius its polynomial may fold back, and
    points outside the view would appear inside the picture.
    """
    width, height = camera.image_size
    picture = np.stack(np.meshgrid(np.linspace(0, width, 33), np.linspace(0, height, 25)), axis=-1).reshape(-1, 2)
    return FOLD_MARGIN * float(np.nanmax(np.linalg.norm(camera.undistort(picture), axis=1)))
