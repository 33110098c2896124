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

import numpy as np

from appliance.cameras.pairing import Exposure, Pairing
from appliance.cameras.source import CameraError, FramePair
from appliance.settings import OakCamera

os.environ["DEPTHAI_AUTOCALIBRATION"] = "OFF"  # both are read when the library is loaded
os.environ.setdefault("DEPTHAI_LEVEL", "error")

import depthai as dai

WAITING = 8  # pictures of a camera that wait to be taken
TEMPERATURE_PERIOD_S = 5.0
AT_ONCE = timedelta(microseconds=1)  # `get` lets other threads run while it waits for a queue; `tryGet` does not
CLOSED = cast("type[Exception]", dai.MessageQueue.QueueException)  # pyright: ignore[reportUnknownMemberType]


@dataclass(frozen=True, slots=True)
class Cameras:
    """The sending ends of a pipeline.

    Attributes
    ----------
    outputs : tuple of Output
        Pictures of the left and of the right camera.
    same_device : bool
        Both count their exposures together and have one clock.
    devices : list of Device
        Whose temperature is watched.
    controls : list of InputQueue
        Take a new exposure; empty where it cannot be set.
    """

    outputs: tuple[dai.Node.Output, dai.Node.Output]
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
    kind = dai.ImgFrame.Type.GRAY8 if settings.pictures == "grey" else dai.ImgFrame.Type.BGR888i
    outputs = [node.requestFullResolutionOutput(kind) for node in nodes]
    return Cameras(
        outputs=(outputs[0], outputs[1]),
        same_device=right is left,
        devices=[left] if right is left else [left, right],
        controls=[node.inputControl.createInputQueue() for node in nodes],
    )


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
    pipeline: dai.Pipeline, device: dai.Device, socket: str, settings: OakCamera, *, follows: bool
) -> dai.node.Camera:
    """One sensor; one that follows another's wire has no rate of its own."""
    node = pipeline.create(dai.node.Camera, device)  # pyright: ignore[reportUnknownMemberType]
    node.build(getattr(dai.CameraBoardSocket, socket), sensorFps=None if follows else settings.rate_hz)
    control = node.initialControl
    control.setManualExposure(settings.exposure_us, settings.sensitivity_iso)
    control.setManualWhiteBalance(settings.white_balance_k)
    control.setManualFocus(settings.focus)
    if settings.right and settings.sync == "ptp":
        control.setFrameSyncMode(dai.CameraControl.FrameSyncMode.TIME_PTP)
    return node


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
        self._pipeline = dai.Pipeline(createImplicitDevice=False)
        self._pipeline.setAutoCalibrationMode(dai.Pipeline.AutoCalibrationMode.OFF)
        self._pipeline.setStopOnDeviceLoss(stop=True)
        try:
            self._there = self._cameras(self._pipeline, self._settings)
            self._queues = [output.createOutputQueue(WAITING, blocking=False) for output in self._there.outputs]
            self._pipeline.start()
        except RuntimeError as error:
            self._close()
            raise CameraError(f"the OAK cameras do not start: {error}; check cable and power") from error
        except CameraError:
            self._close()
            raise
        self._pairing = Pairing(self._in_step_s, same_sequence=self._there.same_device)
        self._measured_s = time.monotonic()
        self._temperature_c = math.nan
        return self

    def __exit__(self, *_: object) -> None:
        """Stop and let go of the devices."""
        self._close()

    def _close(self) -> None:
        with contextlib.suppress(RuntimeError):
            self._pipeline.stop()
            self._pipeline.wait()  # its threads must not outlive the interpreter

    def next(self, timeout_s: float) -> FramePair | None:
        """Newest pair; None when none came in time, `CameraError` when a device is lost."""
        until_s = time.monotonic() + timeout_s
        while (pair := self._newest(until_s)) is None:
            if time.monotonic() >= until_s:
                return None
        self._measure_temperature()
        return replace(pair, temperature_c=self._temperature_c)

    def set_exposure(self, exposure_us: float) -> None:
        """Have the next pictures exposed for another time."""
        control = dai.CameraControl()
        control.setManualExposure(round(exposure_us), self._settings.sensitivity_iso)
        for queue in self._there.controls:
            queue.send(control)

    def _newest(self, until_s: float) -> FramePair | None:
        self._receive(max(until_s - time.monotonic(), 0.001))
        return self._pairing.take()

    def _receive(self, wait_s: float) -> None:
        """Wait for a picture of the camera that is behind, then take all that have come."""
        self._take(self._pairing.behind, timedelta(seconds=wait_s))
        for side in range(len(self._queues)):
            while self._take(side, AT_ONCE):
                pass

    def _take(self, side: int, wait: timedelta) -> bool:
        try:
            frame = cast("dai.ImgFrame | None", self._queues[side].get(wait))
        except CLOSED as error:
            raise CameraError("an OAK camera is gone; check cable and power") from error
        if frame is not None:
            self._pairing.add(side, self._exposure(frame))
        return frame is not None

    def _exposure(self, frame: dai.ImgFrame) -> Exposure:
        # the library's host clock is this machine's monotonic clock; it keeps devices' clocks in step with it
        exposed = frame.getTimestamp(dai.CameraExposureOffset.MIDDLE)
        stamp = frame.getTimestampDevice() if self._there.same_device else exposed
        exposure_us = 1e6 * frame.getExposureTime().total_seconds()
        return Exposure(
            np.asarray(frame.getCvFrame(), dtype=np.uint8),
            sequence=frame.getSequenceNum(),
            device_us=round(1e6 * stamp.total_seconds()),
            exposed_monotonic_s=exposed.total_seconds(),
            exposure_us=exposure_us or math.nan,
        )

    def _measure_temperature(self) -> None:
        now_s = time.monotonic()
        if self._there.devices and now_s - self._measured_s > TEMPERATURE_PERIOD_S:
            self._measured_s = now_s
            with contextlib.suppress(RuntimeError):  # a device that is lost says so by its pictures
                self._temperature_c = max(device.getChipTemperature().average for device in self._there.devices)
