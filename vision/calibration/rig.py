"""A rig (camera calibration): two cameras in the line's coordinates, with the covariance of their parameters."""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from vision.calibration.json_fields import Fields
from vision.calibration.still_marks import NO_MARKS, Marks
from vision.geometry.camera import CAMERA_PARAMETERS, Camera
from vision.light import CURVE_PARAMETERS, NAMED_RESPONSES, NamedResponse, Response, ResponseCurve

FORMAT_VERSION = 1

SIDES = ("left", "right")
BOARD_NAMES = ("left_low", "right_low", "left_high", "right_high")


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """Two cameras in one world frame (mm, z up from the conveyor plane, y along rolling, x across).

    Attributes
    ----------
    left, right : Camera
    covariance : ndarray of float64, shape (30, 30)
        Covariance (k = 1) of the parameters of `perturbed`: the left camera's, then the right one's;
        pixels, radians, mm. The scale of the board and the heights of the registration boards are not in it.
    response : str or ResponseCurve
        How pixel values follow from light.
    region_y_mm : tuple of float
        Measuring region along the rolling direction, on the world's y axis.
    square_relative_u : float
        Relative standard uncertainty of the board's squares; every length scales with it.
    low_mm, high_mm : float
        Heights of the two registration boards over z = 0.
    height_u_mm : float
        Standard uncertainty of those heights.
    boards : dict of str to ndarray of float64, shape (n, 2)
        Corners (x, y), pixels, of the registration boards: `left_low`, `right_low`, `left_high`, `right_high`, in
        the same order of corners; empty where a registration picture is missing.
    residual_px : float
        Root mean square of the reprojection residuals of the calibration, per coordinate.
    has_world : bool
        False when no registration picture fixed the world frame: the frame is then the left camera's own.
    marks : tuple of two Marks
        Still marks in the left and in the right picture; none when the rig was made without registration pictures.
    tilt_deg : float
        How much the line rises along y against the boards, degrees; not 0 for a rig that `along_line` has turned, whose
        frame is the line's.
    """

    left: Camera
    right: Camera
    covariance: NDArray[np.float64]
    response: Response
    region_y_mm: tuple[float, float]
    square_relative_u: float
    low_mm: float
    high_mm: float
    height_u_mm: float
    boards: dict[str, NDArray[np.float64]]
    residual_px: float
    has_world: bool = True
    marks: tuple[Marks, Marks] = (NO_MARKS, NO_MARKS)
    tilt_deg: float = 0.0

    @property
    def line_axes(self) -> NDArray[np.float64]:
        """Axes of the line in the boards' frame, shape (3, 3): a row for each of x, y and z."""
        sine, cosine = np.sin(np.deg2rad(self.tilt_deg)), np.cos(np.deg2rad(self.tilt_deg))
        return np.array([[1.0, 0.0, 0.0], [0.0, cosine, sine], [0.0, -sine, cosine]])

    def along_line(self, tilt_deg: float) -> "Rig":
        """Return the rig in the frame of a line that is not parallel to the boards.

        The frame turns about its x axis until y runs along the line; the covariance, which is of the cameras' own
        axes, stays. The boards stay where they lie.

        Parameters
        ----------
        tilt_deg : float
            How much the line rises along y against the boards, degrees; 0: the boards' own frame.
        """
        turned = replace(self, tilt_deg=tilt_deg)
        turn = self.line_axes @ turned.line_axes.T
        left, right = (replace(camera, R=camera.R @ turn) for camera in (self.left, self.right))
        return replace(turned, left=left, right=right)

    @property
    def baseline_mm(self) -> float:
        """Distance between the two projection centres, mm."""
        return float(np.linalg.norm(self.right.centre_mm - self.left.centre_mm))

    def perturbed(self, delta: NDArray[np.float64]) -> "Rig":
        """Return the rig after small changes of its parameters, the ones that `covariance` is of.

        Parameters
        ----------
        delta : ndarray of float64, shape (30,)
            The left camera's 15 changes, then the right one's; see `Camera.perturbed`.

        Returns
        -------
        Rig

        Raises
        ------
        ValueError
            `delta` has another shape.
        """
        if np.shape(delta) != (2 * len(CAMERA_PARAMETERS),):
            raise ValueError(f"delta: shape {np.shape(delta)} where (30,) is needed")
        return replace(self, left=self.left.perturbed(delta[:15]), right=self.right.perturbed(delta[15:]))

    def standard_uncertainty(self, quantity: Callable[["Rig"], float]) -> float:
        """Propagate the covariance to a quantity that follows from the rig.

        Parameters
        ----------
        quantity : callable
            Maps a rig to a number; differentiated by central differences of one standard uncertainty.

        Returns
        -------
        float
            Standard uncertainty (k = 1) in the quantity's unit; NaN where the quantity is NaN.
        """
        u = np.sqrt(np.diag(self.covariance))
        slope = np.zeros(len(u))
        for index in np.flatnonzero(u):
            step = np.zeros(len(u))
            step[index] = u[index]
            difference = quantity(self.perturbed(step)) - quantity(self.perturbed(-step))
            slope[index] = difference / (2.0 * u[index])
        return float(np.sqrt(slope @ self.covariance @ slope))

    def to_json(self) -> str:
        """Write everything as JSON text, floats in full precision."""
        data: dict[str, object] = {
            "format_version": FORMAT_VERSION,
            "left": _camera_values(self.left),
            "right": _camera_values(self.right),
            "response": response_values(self.response),
            "region_y_mm": list(self.region_y_mm),
            "square_relative_u": self.square_relative_u,
            "low_mm": self.low_mm,
            "high_mm": self.high_mm,
            "height_u_mm": self.height_u_mm,
            "residual_px": self.residual_px,
            "has_world": self.has_world,
            "marks": {side: marks.to_values() for side, marks in zip(SIDES, self.marks, strict=True)},
            "boards": {name: self.boards[name].tolist() for name in BOARD_NAMES},
            "covariance": self.covariance.tolist(),
        }
        return json.dumps(data, indent=1, allow_nan=False) + "\n"

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read what `to_json` wrote.

        Parameters
        ----------
        text : str
            JSON.

        Returns
        -------
        Rig

        Raises
        ------
        ValueError
            One sentence naming the key: not JSON, unknown format version, a key missing, a value of a wrong type,
            shape or range, a number that is not finite, a rotation that is none, a covariance that is none.
        """
        fields = Fields.of_text(text)
        if fields.value("format_version") != FORMAT_VERSION:
            fields.refuse("format_version", f"this version of the program reads version {FORMAT_VERSION} only")
        boards = fields.section("boards")
        return cls(
            left=_read_camera(fields.section("left")),
            right=_read_camera(fields.section("right")),
            covariance=_read_covariance(fields),
            response=read_response(fields),
            region_y_mm=_read_interval(fields, "region_y_mm"),
            square_relative_u=_read_not_negative(fields, "square_relative_u"),
            low_mm=fields.number("low_mm"),
            high_mm=fields.number("high_mm"),
            height_u_mm=_read_not_negative(fields, "height_u_mm"),
            boards={name: boards.array(name, (None, 2)) for name in BOARD_NAMES},
            residual_px=_read_not_negative(fields, "residual_px"),
            has_world=fields.flag("has_world"),
            marks=_read_marks(fields),
        )


def response_values(response: Response) -> object:
    """Response as JSON has it: a name, or an object of a curve's parameters and covariance."""
    if not isinstance(response, ResponseCurve):
        return response
    values = dict(zip(CURVE_PARAMETERS, response.parameters.tolist(), strict=True))
    return {**values, "covariance": response.covariance.tolist()}


def read_response(fields: Fields) -> Response:
    """Read a response's name or curve; `ValueError` names the key and the names allowed."""
    if isinstance(fields.value("response"), dict):
        curve = fields.section("response")
        exponent, offset, shoulder = (curve.number(name) for name in CURVE_PARAMETERS)
        if exponent <= 0.0 or offset <= -1.0 or shoulder <= -1.0:
            fields.refuse("response", "an exponent above 0, an offset and a shoulder above -1 are needed")
        return ResponseCurve(exponent, offset, shoulder, curve.array("covariance", (3, 3)))
    return read_response_name(fields)


def read_response_name(fields: Fields) -> NamedResponse:
    """Read the name of a response; `ValueError` names the key and the names allowed."""
    value: Any = fields.value("response")
    if value not in NAMED_RESPONSES:
        fields.refuse("response", f"one of {', '.join(NAMED_RESPONSES)} is needed, not {value!r}")
    return value


def _camera_values(camera: Camera) -> dict[str, object]:
    return {
        "image_size": list(camera.image_size),
        "K": camera.K.tolist(),
        "dist": camera.dist.tolist(),
        "R": camera.R.tolist(),
        "t": camera.t.tolist(),
    }


def _read_camera(fields: Fields) -> Camera:
    K = fields.array("K", (3, 3))
    if min(K[0, 0], K[1, 1]) <= 0.0 or K[[0, 1, 2, 2], [1, 0, 0, 1]].any() or K[2, 2] != 1.0:
        fields.refuse("K", "an intrinsic matrix [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] is needed")
    R = fields.array("R", (3, 3))
    if np.abs(R @ R.T - np.eye(3)).max() > 1e-9 or np.linalg.det(R) < 0.0:
        fields.refuse("R", "this is no rotation matrix")
    return Camera(
        K=K,
        dist=fields.array("dist", (5,)),
        R=R,
        t=fields.array("t", (3,)),
        image_size=fields.pair_of_counts("image_size"),
    )


def _read_covariance(fields: Fields) -> NDArray[np.float64]:
    covariance = fields.array("covariance", (30, 30))
    u = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation = covariance / np.outer(u, u)
    symmetric = np.abs(correlation - correlation.T).max() < 1e-6
    if not symmetric or np.linalg.eigvalsh(correlation).min() < -1e-6:
        fields.refuse("covariance", "this is no covariance matrix: symmetric, no negative variance")
    return covariance


def _read_marks(fields: Fields) -> tuple[Marks, Marks]:
    """Marks of both cameras; none in a file that was written before there were any."""
    if "marks" not in fields:
        return NO_MARKS, NO_MARKS
    marks = fields.section("marks")
    left, right = (Marks.from_fields(marks.section(side)) for side in SIDES)
    return left, right


def _read_interval(fields: Fields, key: str) -> tuple[float, float]:
    low, high = fields.array(key, (2,)).tolist()
    if low >= high:
        fields.refuse(key, f"the first number must be below the second, not {low:g} and {high:g}")
    return low, high


def _read_not_negative(fields: Fields, key: str) -> float:
    value = fields.number(key)
    if value < 0.0:
        fields.refuse(key, f"a number not below zero is needed, not {value:g}")
    return value
