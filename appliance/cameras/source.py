"""Protocols of all cameras, recordings and simulations, their frames, and their error."""

from dataclasses import dataclass, field
from typing import Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from appliance.errors import HotgaugeError
from appliance.settings.masking import mask
from vision.sent_picture import SentPicture


class CameraError(HotgaugeError):
    """A camera or recording cannot deliver pictures; the message says what, where and what to do.

    Parameters
    ----------
    message : str
        What addresses in it carry of users and passwords is taken out.
    fault : str
        Name in the fault table.
    """

    def __init__(self, message: str, fault: str = "camera_lost") -> None:
        super().__init__(mask(message))
        self.fault = fault


TOGETHER_US = 50  # chosen: a bar that sways with 0.5 mm/ms moves by 0.025 mm in this time


def together(left_us: int, right_us: int) -> bool:
    """Whether two exposures coincide so well that no bar moves between them."""
    return abs(left_us - right_us) <= TOGETHER_US


@dataclass(frozen=True, slots=True)
class FramePair:
    """One simultaneous exposure of both cameras.

    Attributes
    ----------
    left, right : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        Grey, or blue-green-red as OpenCV has it.
    sequence : int
        Number of the exposure, counted by the source from 0; gaps are lost pairs.
    left_us, right_us : int
        Device time stamps of both exposures, in µs on one clock that both cameras share; `liveness` compares them
        with each other and with those of the pair before.
    exposed_monotonic_s : float
        Moment of exposure on this machine's monotonic clock (`time.monotonic`).
    exposed_utc_ms : int
        The same moment as wall time, ms since 1970 UTC.
    exposure_us : float
        Exposure time; NaN if the source does not know it.
    dropped : int
        Pairs discarded since the source was opened, because a newer one was ready.
    temperature_c : float
        Temperature of the hottest camera, °C; NaN if the source does not know it.
    repeated : bool
        Whether a recording delivers the same stored pictures as in the pair before; False for cameras.
    stamped : bool
        Whether `left_us` and `right_us` are moments of exposure that the sensors themselves share; those of two cameras
        that meet on a network, or of a recording without time stamps, are not.
    stretch : int
        Number of the stretch of a recording without a break; a loop or a jump begins another. 0 for cameras.
    truth : dict or None
        True values of a simulated scene (`diameter_mm`, ...); never read by a gauge.
    sent : tuple of two SentPicture, or None
        Both pictures with their coding, where that is more than `left` and `right` tell.
    range_mm : float
        Range that a laser beside the cameras measured at this moment; NaN without one.
    """

    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    sequence: int
    left_us: int
    right_us: int
    exposed_monotonic_s: float
    exposed_utc_ms: int
    exposure_us: float = float("nan")
    dropped: int = 0
    temperature_c: float = float("nan")
    repeated: bool = False
    stamped: bool = False
    stretch: int = 0
    truth: dict[str, object] | None = field(default=None, compare=False)
    sent: tuple[SentPicture, SentPicture] | None = field(default=None, compare=False)
    range_mm: float = float("nan")

    @property
    def synchronous(self) -> bool:
        """Whether time stamps prove that both cameras exposed together."""
        return self.stamped and together(self.left_us, self.right_us)

    @property
    def pictures(self) -> tuple[SentPicture, SentPicture]:
        """Both pictures as a gauge measures them."""
        return self.sent or (SentPicture.of(self.left), SentPicture.of(self.right))


@dataclass(frozen=True, slots=True)
class Frame:
    """One exposure of a single camera.

    Attributes
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        Grey, or blue-green-red as OpenCV has it.
    sequence : int
        Number of the exposure, counted by the source from 0; gaps are lost pictures.
    exposed_monotonic_s : float
        Moment of exposure on this machine's monotonic clock (`time.monotonic`).
    exposed_utc_ms : int
        The same moment as wall time, ms since 1970 UTC.
    exposure_us : float
        Exposure time; NaN if the source does not know it.
    dropped : int
        Pictures discarded since the source was opened, because a newer one was ready.
    device_us : int or None
        Device time stamp, µs; None if the source has none.
    temperature_c : float
        Temperature of the camera, °C; NaN if the source does not know it.
    repeated : bool
        Whether a recording delivers the same stored picture as the one before; False for cameras.
    stretch : int
        Number of the stretch of a recording without a break; a loop or a jump begins another. 0 for cameras.
    truth : dict or None
        True values of a simulated scene (`state`, `label`, ...); never read by a gauge.
    sent : SentPicture or None
        The picture with its coding, where that is more than `picture` tells.
    """

    picture: NDArray[np.uint8]
    sequence: int
    exposed_monotonic_s: float
    exposed_utc_ms: int
    exposure_us: float = float("nan")
    dropped: int = 0
    device_us: int | None = None
    temperature_c: float = float("nan")
    repeated: bool = False
    stretch: int = 0
    truth: dict[str, object] | None = field(default=None, compare=False)
    sent: SentPicture | None = field(default=None, compare=False)

    @property
    def pictures(self) -> tuple[SentPicture]:
        """The picture as a gauge of a single camera measures it."""
        return (self.sent or SentPicture.of(self.picture),)


class PairSource(Protocol):
    """A source of image pairs. Use it as a context manager: entering opens it, leaving closes it."""

    @property
    def simulated(self) -> bool:
        """Whether the pictures come from a simulation or a recording and show no present bar."""
        ...

    def __enter__(self) -> Self:
        """Open the source; raises `CameraError`."""
        ...

    def __exit__(self, *_: object) -> None:
        """Release everything; never raises."""
        ...

    def next(self, timeout_s: float) -> FramePair | None:
        """Wait for the newest pair that was not delivered yet.

        Older ones are discarded and counted in `FramePair.dropped`. The caller may change the pictures.

        Parameters
        ----------
        timeout_s : float
            Longest wait, seconds.

        Returns
        -------
        FramePair or None
            None if no pair came in time.

        Raises
        ------
        EndOfRecording
            The recording is over.
        CameraError
            The camera can deliver no more pictures.
        """
        ...


@runtime_checkable
class Adjustable(Protocol):
    """A source whose exposure time can be set while it runs."""

    def set_exposure(self, exposure_us: float) -> None:
        """Set the exposure time of the next pictures, µs."""
        ...


class PictureSource(Protocol):
    """A source of single pictures. Use it as a context manager: entering opens it, leaving closes it."""

    @property
    def simulated(self) -> bool:
        """Whether the pictures come from a simulation or a recording and show no present line."""
        ...

    def __enter__(self) -> Self:
        """Open the source; raises `CameraError`."""
        ...

    def __exit__(self, *_: object) -> None:
        """Release everything; never raises."""
        ...

    def next(self, timeout_s: float) -> Frame | None:
        """Wait at most `timeout_s` for the newest picture that was not delivered yet; None if none came in time.

        Older ones are discarded and counted in `Frame.dropped`. Raises as `PairSource.next` does.
        """
        ...


class EndOfRecording(CameraError):  # noqa: N818  an end is not an error of anybody's
    """The recording was played once and is over."""

    def __init__(self, message: str) -> None:
        super().__init__(message, "recording_over")
