"""Image pairs and pictures of GenICam cameras."""

import contextlib
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Self

from appliance.cameras.genicam.device import Device
from appliance.cameras.genicam.settings import GenicamCamera, GenicamPictures, GenicamSection
from appliance.cameras.genicam.trigger import ACTION, SOFTWARE, ActionCommand, Firing
from appliance.cameras.newest_picture import NewestPicture
from appliance.cameras.pairing import Pairing
from appliance.cameras.source import Frame, FramePair


class GenicamSource:
    """Image pairs of two cameras; see `PairSource`.

    Parameters
    ----------
    settings : GenicamCamera
    in_step_us : float
        Longest time between two exposures of one pair.
    """

    simulated = False

    def __init__(self, settings: GenicamCamera, in_step_us: float) -> None:
        self._settings = settings
        self._in_step_s = in_step_us / 1e6

    def __enter__(self) -> Self:
        """Open and start both cameras; raises `CameraError`."""
        with contextlib.ExitStack() as opened:
            self._devices: list[Device] = []
            for serial in (self._settings.left, self._settings.right):
                self._devices.append(Device(serial, self._settings))
                opened.callback(self._devices[-1].close)
            _fire(self._devices, self._settings, opened)
            for device in self._devices:
                device.wait_for_first()
            for device in self._devices:  # what the left one sent meanwhile would be paired with the right one's newest
                device.discard_waiting()
            self._close = opened.pop_all()
        self._pairing = Pairing(self._in_step_s, same_sequence=False)
        return self

    def __exit__(self, *_: object) -> None:
        """Stop both cameras."""
        self._close.close()

    def next(self, timeout_s: float) -> FramePair | None:
        """Newest pair; None when none came in time, `CameraError` when a camera is lost."""
        until_s = time.monotonic() + timeout_s
        while (pair := self._newest(until_s)) is None:
            if time.monotonic() >= until_s:
                return None
        return replace(pair, temperature_c=max(device.temperature_c() for device in self._devices))

    def set_exposure(self, exposure_us: float) -> None:
        """Have the next pictures exposed for another time."""
        for device in self._devices:
            device.set_exposure(exposure_us)

    def _newest(self, until_s: float) -> FramePair | None:
        """Wait for a picture of the camera that is behind, then take all that have come."""
        self._add(self._pairing.behind, max(until_s - time.monotonic(), 0.001))
        for side in (0, 1):
            while self._add(side, 0.0):
                pass
        return self._pairing.newest_pair()

    def _add(self, side: int, wait_s: float) -> bool:
        exposure = self._devices[side].take(wait_s)
        if exposure is None:
            return False
        if not self._settings.common_clock:  # the devices' own stamps cannot be compared
            exposure = exposure._replace(device_us=round(1e6 * exposure.exposed_monotonic_s))
        self._pairing.add(side, exposure)
        return True


class GenicamPictureSource:
    """Pictures of one camera; see `PictureSource`.

    Parameters
    ----------
    settings : GenicamPictures
    """

    simulated = False

    def __init__(self, settings: GenicamPictures) -> None:
        self._settings = settings

    def __enter__(self) -> Self:
        """Open and start the camera; raises `CameraError`."""
        with contextlib.ExitStack() as opened:
            self._device = Device(self._settings.serial, self._settings)
            opened.callback(self._device.close)
            _fire([self._device], self._settings, opened)
            self._device.wait_for_first()
            self._close = opened.pop_all()
        self._newest = NewestPicture(self._device.take, self._device.temperature_c)
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the camera."""
        self._close.close()

    def next(self, timeout_s: float) -> Frame | None:
        """Newest picture; None when none came in time, `CameraError` when the camera is lost."""
        return self._newest.next(timeout_s)

    def set_exposure(self, exposure_us: float) -> None:
        """Have the next pictures exposed for another time."""
        self._device.set_exposure(exposure_us)


def _fire(devices: Sequence[Device], settings: GenicamSection, opened: contextlib.ExitStack) -> None:
    """Begin to fire cameras that wait for this computer, until `opened` is closed."""
    if settings.trigger == SOFTWARE:

        def fire() -> None:
            for device in devices:
                device.fire()

        opened.callback(Firing(fire, settings.rate_hz).close)
    elif settings.trigger == ACTION:
        command = ActionCommand(device.card for device in devices)
        opened.callback(command.close)

        def fire_all() -> None:
            command.send(_moment_ns(devices[0], settings.ahead_s) if settings.ahead_s else None)

        opened.callback(Firing(fire_all, settings.rate_hz).close)


def _moment_ns(device: Device, ahead_s: float) -> int | None:
    """When the next exposure is due by the cameras' clock; None until a picture has shown that clock."""
    shown_s = device.own_clock_s()
    return None if shown_s is None else round(1e9 * (shown_s + ahead_s))
