"""OAK cameras: one device with two sensors, or two devices that are synchronised by wire or by PTP.

The only importer of depthai. Nothing is left to the camera's own judgement: exposure, focus and white balance are
fixed, and the device does not recalibrate itself. A device that is lost ends the source with a `CameraError`; who
uses it opens it again.
"""

import contextlib
import math
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import timedelta
from typing import Self, cast

import depthai as dai
import numpy as np

from appliance.cameras.newest_picture import NewestPicture
from appliance.cameras.oak.settings import OakCamera, OakPictures
from appliance.cameras.pairing import Exposure, Pairing
from appliance.cameras.source import CameraError, Frame, FramePair
from vision.sent_picture import Coding, SentPicture, sent_picture

os.environ["DEPTHAI_AUTOCALIBRATION"] = "OFF"  # both are read when the library is loaded
os.environ.setdefault("DEPTHAI_LEVEL", "error")

NV12_CODING = Coding("luma", full_range=False)
QUEUE_PICTURES = 8  # pictures of a camera that wait to be taken
TEMPERATURE_PERIOD_S = 5.0
NO_WAIT = timedelta(microseconds=1)  # `get` lets other threads run while it waits for a queue; `tryGet` does not
QUEUE_CLOSED_ERROR = cast("type[Exception]", dai.MessageQueue.QueueException)  # pyright: ignore[reportUnknownMemberType]


@dataclass(frozen=True, slots=True)
class Cameras:
    """The sending ends of a pipeline.

    Attributes
    ----------
    outputs : tuple of Output
        Pictures of the left and of the right camera, or of the only one.
    same_device : bool
        Both count their exposures together and have one clock.
    devices : list of Device
        Whose temperature is watched.
    controls : list of InputQueue
        Take a new exposure; empty where it cannot be set.
    """

    outputs: tuple[dai.Node.Output, ...]
    same_device: bool
    devices: list[dai.Device] = field(default_factory=list[dai.Device])
    controls: list[dai.InputQueue] = field(default_factory=list[dai.InputQueue])


def device_cameras(pipeline: dai.Pipeline, settings: OakCamera) -> Cameras:
    """Cameras of the connected devices, all settings fixed.

    Raises
    ------
    CameraError
        A device cannot be found or opened.
    """
    left = _open(pipeline, settings.left)
    right = _open(pipeline, settings.right) if settings.right else left
    nodes = [
        _camera(pipeline, device, socket, settings, follows=follows)
        for device, socket, follows in (
            (left, settings.left_socket, False),
            (right, settings.right_socket, right is not left and settings.sync == "wire"),
        )
    ]
    if right is not left and settings.sync == "wire":
        left.setExternalStrobeEnable(enable=True)
    kind = dai.ImgFrame.Type.GRAY8 if settings.pictures == "grey" else dai.ImgFrame.Type.NV12
    outputs = [node.requestFullResolutionOutput(kind) for node in nodes]
    return Cameras(
        outputs=tuple(outputs),
        same_device=right is left,
        devices=[left] if right is left else [left, right],
        controls=[node.inputControl.createInputQueue() for node in nodes],
    )


def device_camera(pipeline: dai.Pipeline, settings: OakPictures) -> Cameras:
    """The camera of one sensor, in colour, all settings fixed; raises `CameraError` like `device_cameras`."""
    device = _open(pipeline, settings.device)
    node = _camera(pipeline, device, settings.socket, settings, follows=False)
    output = node.requestFullResolutionOutput(dai.ImgFrame.Type.NV12)
    return Cameras(
        outputs=(output,), same_device=True, devices=[device], controls=[node.inputControl.createInputQueue()]
    )


def connected() -> list[str]:
    """Return a line for every device that answers to a search."""
    return [f"{info.deviceId}: {info.name}" for info in dai.Device.getAllAvailableDevices()]


def _open(pipeline: dai.Pipeline, name: str) -> dai.Device:
    # asking first: opening a device that is not there takes the library more than ten seconds
    there = dai.Device.getAllAvailableDevices()
    named = [info for info in there if name in {"", info.deviceId, info.name}]
    if not named and "." not in name:  # an address may lie beyond what answers to a search
        seen = ", ".join(info.deviceId for info in there) or "none"
        raise CameraError(f"no OAK camera {name or 'at all'} is connected; there are: {seen}; check cable and power")
    try:
        device = pipeline.addDevice(named[0] if named else name)
        device.setMaxReconnectionAttempts(0)  # a lost device ends the stream instead of leaving it silent
    except RuntimeError as error:
        raise CameraError(
            f"OAK camera {name or named[0].deviceId}: {error}; check cable, power and udev rule"
        ) from error
    return device


def _camera(
    pipeline: dai.Pipeline, device: dai.Device, socket: str, settings: OakCamera | OakPictures, *, follows: bool
) -> dai.node.Camera:
    """One sensor; one that follows another's wire has no rate of its own."""
    node = pipeline.create(dai.node.Camera, device)  # pyright: ignore[reportUnknownMemberType]
    node.build(getattr(dai.CameraBoardSocket, socket), sensorFps=None if follows else settings.rate_hz)
    control = node.initialControl
    control.setManualExposure(settings.exposure_us, settings.sensitivity_iso)
    control.setManualWhiteBalance(settings.white_balance_k)
    control.setManualFocus(settings.focus)
    # what a camera smooths or sharpens after it has coded the light moves edges
    control.setSharpness(0)
    control.setLumaDenoise(0)
    control.setChromaDenoise(0)
    if isinstance(settings, OakCamera) and settings.right and settings.sync == "ptp":
        control.setFrameSyncMode(dai.CameraControl.FrameSyncMode.TIME_PTP)
    return node


def picture_of_frame(frame: dai.ImgFrame) -> SentPicture:
    """SentPicture of a frame: of NV12 luma is measured as the sensor's processor made it, and colours are shown.

    The library takes NV12 for BT.601 of limited range, and so do we; what a device's processor does is not known.

    Parameters
    ----------
    frame : dai.ImgFrame
    """
    shown = np.asarray(frame.getCvFrame(), dtype=np.uint8)
    if frame.getType() != dai.ImgFrame.Type.NV12:
        return SentPicture.of(shown)
    rows, columns = shown.shape[:2]
    data = np.asarray(frame.getData(), dtype=np.uint8)
    luma = data[: frame.getStride() * rows].reshape(rows, frame.getStride())[:, :columns]
    return sent_picture(np.ascontiguousarray(luma), NV12_CODING, shown)


class _Open:
    """Cameras that run: their queues, their temperature, their end."""

    def __init__(self, fill: Callable[[dai.Pipeline], Cameras]) -> None:
        self._pipeline = dai.Pipeline(createImplicitDevice=False)
        self._pipeline.setAutoCalibrationMode(dai.Pipeline.AutoCalibrationMode.OFF)
        self._pipeline.setStopOnDeviceLoss(stop=True)
        try:
            self.cameras = fill(self._pipeline)
            self._queues = [output.createOutputQueue(QUEUE_PICTURES, blocking=False) for output in self.cameras.outputs]
            self._pipeline.start()
        except RuntimeError as error:
            self.close()
            raise CameraError(f"the OAK cameras do not start: {error}; check cable and power") from error
        except CameraError:
            self.close()
            raise
        self._measured_s = time.monotonic()
        self._temperature_c = math.nan

    def close(self) -> None:
        with contextlib.suppress(RuntimeError):
            self._pipeline.stop()
            self._pipeline.wait()  # its threads must not outlive the interpreter

    def take(self, side: int, wait_s: float) -> Exposure | None:
        """Next picture of a camera; None when none came in time, `CameraError` when the device is lost."""
        try:
            frame = cast("dai.ImgFrame | None", self._queues[side].get(max(NO_WAIT, timedelta(seconds=wait_s))))
        except QUEUE_CLOSED_ERROR as error:
            raise CameraError("an OAK camera is gone; check cable and power") from error
        return None if frame is None else self._exposure(frame)

    def _exposure(self, frame: dai.ImgFrame) -> Exposure:
        # the library's host clock is this machine's monotonic clock; it keeps devices' clocks in step with it
        exposed = frame.getTimestamp(dai.CameraExposureOffset.MIDDLE)
        stamp = frame.getTimestampDevice() if self.cameras.same_device else exposed
        exposure_us = 1e6 * frame.getExposureTime().total_seconds()
        return Exposure(
            picture_of_frame(frame),
            sequence=frame.getSequenceNum(),
            device_us=round(1e6 * stamp.total_seconds()),
            exposed_monotonic_s=exposed.total_seconds(),
            exposure_us=exposure_us or math.nan,
        )

    def set_exposure(self, exposure_us: float, sensitivity_iso: int) -> None:
        control = dai.CameraControl()
        control.setManualExposure(round(exposure_us), sensitivity_iso)
        with contextlib.suppress(RuntimeError, QUEUE_CLOSED_ERROR):  # a lost device says so by its pictures
            for queue in self.cameras.controls:
                queue.send(control)

    def temperature_c(self) -> float:
        """Of the hottest device, asked for now and then; NaN when it is not known."""
        now_s = time.monotonic()
        if self.cameras.devices and now_s - self._measured_s > TEMPERATURE_PERIOD_S:
            self._measured_s = now_s
            with contextlib.suppress(RuntimeError):  # a device that is lost says so by its pictures
                self._temperature_c = max(device.getChipTemperature().average for device in self.cameras.devices)
        return self._temperature_c


class OakSource:
    """Image pairs of OAK cameras; see `PairSource`.

    Parameters
    ----------
    settings : OakCamera
    in_step_us : float
        Longest time between two exposures of one pair.
    cameras : callable
        Puts the cameras into a pipeline; by default those of the devices, in tests nodes that play a recording.
    """

    simulated = False

    def __init__(
        self,
        settings: OakCamera,
        in_step_us: float,
        cameras: Callable[[dai.Pipeline, OakCamera], Cameras] = device_cameras,
    ) -> None:
        self._settings = settings
        self._in_step_s = in_step_us / 1e6
        self._cameras = cameras

    def __enter__(self) -> Self:
        """Open the devices and start them; raises `CameraError`."""
        self._open = _Open(lambda pipeline: self._cameras(pipeline, self._settings))
        self._pairing = Pairing(self._in_step_s, same_sequence=self._open.cameras.same_device)
        return self

    def __exit__(self, *_: object) -> None:
        """Stop and let go of the devices."""
        self._open.close()

    def next(self, timeout_s: float) -> FramePair | None:
        """Newest pair; None when none came in time, `CameraError` when a device is lost."""
        until_s = time.monotonic() + timeout_s
        while (pair := self._newest(until_s)) is None:
            if time.monotonic() >= until_s:
                return None
        return replace(pair, temperature_c=self._open.temperature_c())

    def set_exposure(self, exposure_us: float) -> None:
        """Have the next pictures exposed for another time."""
        self._open.set_exposure(exposure_us, self._settings.sensitivity_iso)

    def _newest(self, until_s: float) -> FramePair | None:
        """Wait for a picture of the camera that is behind, then take all that have come."""
        wait_s = max(until_s - time.monotonic(), 0.001)
        self._add(self._pairing.behind, wait_s)
        for side in (0, 1):
            while self._add(side, 0.0):
                pass
        return self._pairing.newest_pair()

    def _add(self, side: int, wait_s: float) -> bool:
        exposure = self._open.take(side, wait_s)
        if exposure is not None:
            self._pairing.add(side, exposure)
        return exposure is not None


class OakPictureSource:
    """Pictures of one sensor of an OAK camera; see `PictureSource`.

    Parameters
    ----------
    settings : OakPictures
    camera : callable
        Puts the camera into a pipeline; by default that of the device.
    """

    simulated = False

    def __init__(
        self, settings: OakPictures, camera: Callable[[dai.Pipeline, OakPictures], Cameras] = device_camera
    ) -> None:
        self._settings = settings
        self._camera = camera

    def __enter__(self) -> Self:
        """Open the device and start it; raises `CameraError`."""
        self._open = _Open(lambda pipeline: self._camera(pipeline, self._settings))
        self._newest = NewestPicture(lambda wait_s: self._open.take(0, wait_s), self._open.temperature_c)
        return self

    def __exit__(self, *_: object) -> None:
        """Stop and let go of the device."""
        self._open.close()

    def next(self, timeout_s: float) -> Frame | None:
        """Newest picture; None when none came in time, `CameraError` when the device is lost."""
        return self._newest.next(timeout_s)

    def set_exposure(self, exposure_us: float) -> None:
        """Have the next pictures exposed for another time."""
        self._open.set_exposure(exposure_us, self._settings.sensitivity_iso)
