"""The one protocol behind which every camera, recording and simulation stands."""

from dataclasses import dataclass, field
from typing import Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from appliance.errors import HotgaugeError


class CameraError(HotgaugeError):
    """A source cannot deliver pictures; the message says what, where and what to do.

    Parameters
    ----------
    message : str
    fault : str
        Name in the fault table.
    """

    def __init__(self, message: str, fault: str = "camera_lost") -> None:
        super().__init__(message)
        self.fault = fault


@dataclass(frozen=True, slots=True)
class FramePair:
    """One simultaneous exposure of both cameras.

    Attributes
    ----------
    left, right : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        Grey, or blue-green-red as OpenCV has it.
    sequence : int
        Number that the source gave the exposure, from 0, +1 each; gaps are lost pairs.
    left_us, right_us : int
        Device time stamps of both exposures, in µs on one clock that both cameras share; `liveness` compares them
        with each other and with those of the pair before.
    exposed_monotonic_s : float
        Moment of exposure on this machine's monotonic clock (`time.monotonic`).
    exposed_utc_ms : int
        The same moment for people, ms since 1970 UTC.
    exposure_us : float
        Exposure time; NaN where the source cannot say.
    dropped : int
        Pairs that the source had discarded, since it was opened, because a newer one was ready.
    temperature_c : float
        Of the hottest camera, in degrees Celsius; NaN where the source cannot say.
    repeated : bool
        The source knows that these are the same stored pictures as in the pair before; a camera never does.
    truth : dict or None
        What a simulation knows about the scene (`diameter_mm`, ...); never read by a gauge.
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
    truth: dict[str, object] | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Frame:
    """One exposure of a single camera.

    Attributes
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        Grey, or blue-green-red as OpenCV has it.
    sequence : int
        Number that the source gave the exposure, from 0, +1 each; gaps are lost pictures.
    exposed_monotonic_s : float
        Moment of exposure on this machine's monotonic clock (`time.monotonic`).
    exposed_utc_ms : int
        The same moment for people, ms since 1970 UTC.
    exposure_us : float
        Exposure time; NaN where the source cannot say.
    dropped : int
        Pictures that the source had discarded, since it was opened, because a newer one was ready.
    device_us : int or None
        Device time stamp, µs; None where the source has none.
    temperature_c : float
        Of the camera, in degrees Celsius; NaN where the source cannot say.
    repeated : bool
        The source knows that this is the same stored picture as the one before; a camera never does.
    truth : dict or None
        What a simulation knows about the scene (`state`, `label`, ...); never read by a gauge.
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
    truth: dict[str, object] | None = field(default=None, compare=False)


class PairSource(Protocol):
    """A source of image pairs. Use it as a context manager: entering opens it, leaving closes it."""

    @property
    def simulated(self) -> bool:
        """Whether the pictures are not of a bar that is there now (mill, recording)."""
        ...

    def __enter__(self) -> Self:
        """Open the source; raises `CameraError`."""
        ...

    def __exit__(self, *_: object) -> None:
        """Release everything; never raises."""
        ...

    def next(self, timeout_s: float) -> FramePair | None:
        """Newest pair not delivered yet.

        Older ones are discarded and counted in `FramePair.dropped`. The pictures are the receiver's own.

        Parameters
        ----------
        timeout_s : float
            Longest time to wait.

        Returns
        -------
        FramePair or None
            None when nothing came in time; a source that has come to its end raises `EndOfRecording`.
        """
        ...


@runtime_checkable
class Adjustable(Protocol):
    """A source whose cameras take a new exposure while they run."""

    def set_exposure(self, exposure_us: float) -> None:
        """Have the next pictures exposed for another time."""
        ...


class PictureSource(Protocol):
    """A source of single pictures. Use it as a context manager: entering opens it, leaving closes it."""

    @property
    def simulated(self) -> bool:
        """Whether the pictures are not of a line that is there now (mill, recording)."""
        ...

    def __enter__(self) -> Self:
        """Open the source; raises `CameraError`."""
        ...

    def __exit__(self, *_: object) -> None:
        """Release everything; never raises."""
        ...

    def next(self, timeout_s: float) -> Frame | None:
        """Newest picture not delivered yet, waited for at most `timeout_s`; None when none came in time.

        Older ones are discarded and counted in `Frame.dropped`; a source at its end raises `EndOfRecording`.
        """
        ...


class EndOfRecording(CameraError):  # noqa: N818  an end is not an error of anybody's
    """The recording was played once and is over."""

    def __init__(self, message: str) -> None:
        super().__init__(message, "recording_over")
