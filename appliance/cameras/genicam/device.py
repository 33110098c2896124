"""One GenICam camera through Aravis: its settings, its stream, its pictures with their coding.

Aravis' Python interface is made at run time and has no types of its own.
"""

import importlib
import math
import socket
import time
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from appliance.cameras.genicam.settings import GenicamSection
from appliance.cameras.genicam.trigger import ACTION, CONTROL_PORT, DEVICE_KEY, GROUP_KEY, GROUP_MASK
from appliance.cameras.pairing import Exposure
from appliance.cameras.picture_clock import Arrival, PresentationClock
from appliance.cameras.source import CameraError
from vision.sent_picture import Coding, Mosaic, SentPicture, sent_picture

importlib.import_module("gi").require_version("Aravis", "0.8")
Aravis = cast("Any", importlib.import_module("gi.repository.Aravis"))
GLib = cast("Any", importlib.import_module("gi.repository.GLib"))

BUFFERS = 8
LAST_16_BIT_ID = 65535  # of a GigE Vision 1 stream; 1 follows (AIA GigE Vision 1.2, block id)
FIRST_TIME_S, FIRST_WAIT_S = 10.0, 0.2  # from opening to the first picture whose moment is known
INCOMPLETE_TIME_S = 3.0  # of pictures that all came incomplete
TEMPERATURE_PERIOD_S = 5.0
EXPOSURE_CHUNK = "ExposureTime"
PTP_FEATURES = ("PtpEnable", "GevIEEE1588")  # GenICam SFNC 2.7, and what it was before 2.0
ACTION_FEATURES = {
    "ActionSelector": 1, "ActionDeviceKey": DEVICE_KEY, "ActionGroupKey": GROUP_KEY, "ActionGroupMask": GROUP_MASK,
}  # fmt: skip
IP_MTU = 14  # of Linux; Python has no name for it
JUMBO_FROM_BYTES = 1500  # largest of Ethernet without them (IEEE 802.3)
MOSAICS: dict[str, Mosaic] = {"RG": "RGGB", "GR": "GRBG", "GB": "GBRG", "BG": "BGGR"}


class Connected(NamedTuple):
    """A camera that answers.

    Attributes
    ----------
    device : str
        Aravis' name of it.
    serial, model, address, protocol : str
    """

    device: str
    serial: str
    model: str
    address: str
    protocol: str


def connected() -> list[Connected]:
    """Every camera that answers to a search."""
    Aravis.update_device_list()
    return [
        Connected(
            Aravis.get_device_id(number),
            Aravis.get_device_serial_nbr(number),
            Aravis.get_device_model(number),
            Aravis.get_device_address(number),
            Aravis.get_device_protocol(number),
        )
        for number in range(Aravis.get_n_devices())
    ]


def described(camera: Connected) -> str:
    """Serial number, model, address, size and formats of a camera, or why it cannot be opened."""
    where = f"{camera.serial}: {camera.model}, {camera.protocol} {camera.address}".rstrip()
    try:
        opened = Aravis.Camera.new(camera.device)
        columns, rows = opened.get_sensor_size()
        formats = ", ".join(opened.dup_available_pixel_formats_as_strings())
        packets = _packet_hint(opened.gv_get_packet_size()) if opened.is_gv_device() else ""
    except GLib.Error as error:
        return f"{where}, cannot be opened: {_sentence(error)}"
    return f"{where}, {columns} x {rows} pixels, {formats}{packets}"


def _packet_hint(packet_bytes: int) -> str:
    """What a small packet size costs; jumbo frames are those above 1500 bytes."""
    if packet_bytes > JUMBO_FROM_BYTES:
        return f", packets of {packet_bytes} bytes"
    return f", packets of {packet_bytes} bytes: set the network card's MTU to 9000 for fewer lost pictures"


class Device:
    """An open camera that sends pictures; see `Exposure`.

    Parameters
    ----------
    serial : str
        Its serial number.
    settings : GenicamSection

    Raises
    ------
    CameraError
        It does not answer, is used by another program, or refuses a setting.
    """

    def __init__(self, serial: str, settings: GenicamSection) -> None:
        self._name = f"camera {serial}"
        self._settings = settings
        self._coding = _coding(settings.pixel_format)
        self._clock = PresentationClock(settings.delay_ms / 1000)
        self._last_id: int | None = None
        self._number = 0
        self._complete_s = self._measured_s = time.monotonic()
        self._incomplete = 0
        self._gone = False
        self._ahead_s: float | None = None  # of the camera's clock before this computer's
        self._temperature_c = math.nan
        try:
            self._camera = Aravis.Camera.new(_device_of(serial))
            self._set_up()
            self._stream = self._camera.create_stream(None, None)
            for _ in range(BUFFERS):
                self._stream.push_buffer(Aravis.Buffer.new_allocate(self._camera.get_payload()))
            self._camera.get_device().connect("control-lost", self._lose)
            self._chunks = self._camera.create_chunk_parser() if settings.chunk_data else None
            self._camera.start_acquisition()
        except OSError as error:
            raise CameraError(f"{self._name}: {error.strerror}; check cable and network") from error
        except GLib.Error as error:
            raise CameraError(f"{self._name}: {_sentence(error)}; check cable, power and other programs") from None

    def close(self) -> None:
        """Stop the camera; one that is gone is left."""
        try:
            self._camera.stop_acquisition()
        except GLib.Error:
            self._gone = True
        del self._stream, self._camera

    def take(self, wait_s: float) -> Exposure | None:
        """Next picture that is complete and whose moment is known; None when none came in time.

        Raises
        ------
        CameraError
            The camera is gone, pictures keep coming incomplete, or its time stamps jump.
        """
        if self._gone:
            raise CameraError(f"{self._name} is gone; check cable and power")
        asked_s = time.monotonic()
        buffer = self._stream.timeout_pop_buffer(max(0, round(1e6 * wait_s)))
        if buffer is None:
            return None
        try:
            return self._exposure(buffer, asked_s)
        finally:
            self._stream.push_buffer(buffer)

    def wait_for_first(self) -> None:
        """Wait until a picture has come whose moment is known; raises `CameraError` when none does."""
        until_s = time.monotonic() + FIRST_TIME_S
        while self.take(FIRST_WAIT_S) is None:
            if time.monotonic() > until_s:
                raise CameraError(f"{self._name} sends no picture within {FIRST_TIME_S:g} s; check trigger and cable")

    def discard_waiting(self) -> None:
        """Count and discard the pictures that have come and were not asked for; raises `CameraError`; see `take`."""
        for _ in range(BUFFERS):
            self.take(0.0)

    def set_exposure(self, exposure_us: float) -> None:
        """Have the next pictures exposed for another time; a camera that is gone says so by its pictures."""
        try:
            self._camera.set_exposure_time(exposure_us)
        except GLib.Error:
            self._gone = True

    @property
    def card(self) -> str:
        """Address of the network card that the camera is connected to; empty for a camera without a network."""
        if not self._camera.is_gv_device():
            return ""
        return str(self._camera.get_device().get_interface_address().get_address().to_string())

    def own_clock_s(self) -> float | None:
        """What the camera's clock shows now, as its newest picture tells; None before the first."""
        return None if self._ahead_s is None else time.monotonic() + self._ahead_s

    def fire(self) -> None:
        """Expose now, a camera whose trigger is Software; one that is gone says so by its pictures."""
        try:
            self._camera.software_trigger()
        except GLib.Error:
            self._gone = True

    def temperature_c(self) -> float:
        """Of the camera, asked for now and then; NaN when it does not tell."""
        now_s = time.monotonic()
        if now_s - self._measured_s > TEMPERATURE_PERIOD_S:
            self._measured_s = now_s
            device = self._camera.get_device()
            try:
                if device.is_feature_available("DeviceTemperature"):
                    self._temperature_c = device.get_float_feature_value("DeviceTemperature")
            except GLib.Error:
                self._temperature_c = math.nan
        return self._temperature_c

    def _lose(self, _: object) -> None:
        self._gone = True

    def _set_up(self) -> None:
        """Fix all settings; what a camera does by itself moves edges."""
        camera, settings = self._camera, self._settings
        formats = list(camera.dup_available_pixel_formats_as_strings())
        if settings.pixel_format not in formats:
            raise CameraError(f"{self._name} does not send {settings.pixel_format}; set one of {', '.join(formats)}")
        camera.set_acquisition_mode(Aravis.AcquisitionMode.CONTINUOUS)
        camera.set_pixel_format_from_string(settings.pixel_format)
        columns, rows = camera.get_sensor_size()
        camera.set_region(*(settings.region or (0, 0, columns, rows)))
        self._set_light()
        if settings.trigger:
            sources = list(camera.dup_available_trigger_sources())
            if settings.trigger not in sources:
                raise CameraError(f"{self._name} has no trigger {settings.trigger}; set one of {', '.join(sources)}")
            camera.set_trigger(settings.trigger)
        else:
            camera.clear_triggers()
            camera.set_frame_rate(settings.rate_hz)
        self._set_network()
        if settings.chunk_data:
            if not camera.are_chunks_available():
                raise CameraError(f"{self._name} sends no chunk data; leave chunk_data out")
            camera.set_chunks(EXPOSURE_CHUNK)

    def _set_network(self) -> None:
        """Packets, clock and action commands, of cameras on a network."""
        camera, settings = self._camera, self._settings
        if camera.is_gv_device():
            self._set_packets()
        if settings.wants_ptp:
            for feature in PTP_FEATURES:
                if camera.is_feature_available(feature):
                    camera.set_boolean(feature, True)
        if settings.trigger == ACTION:
            for feature, value in ACTION_FEATURES.items():
                camera.set_integer(feature, value)

    def _set_packets(self) -> None:
        """Packets as they are set, else as large as pass: a camera that cannot try keeps a size that may not."""
        camera, wanted_bytes = self._camera, self._settings.packet_bytes
        most_bytes = _path_bytes(camera.get_device().get_device_address().get_address().to_string())
        if wanted_bytes > most_bytes:
            raise CameraError(
                f"{self._name}: packets of {wanted_bytes} bytes do not pass, {most_bytes} do; set packet_bytes to "
                "that, or the network card's MTU higher"
            )
        if wanted_bytes:
            camera.gv_set_packet_size(wanted_bytes)
            return
        camera.gv_auto_packet_size()
        if camera.gv_get_packet_size() > most_bytes:
            camera.gv_set_packet_size(most_bytes)

    def _set_light(self) -> None:
        camera, settings = self._camera, self._settings
        if camera.is_exposure_auto_available():
            camera.set_exposure_time_auto(Aravis.Auto.OFF)
        if camera.is_gain_auto_available():
            camera.set_gain_auto(Aravis.Auto.OFF)
        camera.set_exposure_time(settings.exposure_us)
        if camera.is_gain_available():
            camera.set_gain(settings.gain_db)
        if camera.is_black_level_available():
            camera.set_black_level(settings.black_level)
        elif settings.black_level:
            raise CameraError(f"{self._name} has no black level; leave black_level out")

    def _exposure(self, buffer: Any, asked_s: float) -> Exposure | None:
        in_order = self._count(buffer.get_frame_id())
        now_s = time.monotonic()
        whole = in_order and buffer.get_status() == Aravis.BufferStatus.SUCCESS
        picture = self._picture(buffer) if whole else None
        if picture is None:
            self._incomplete += 1
            self._refuse_incomplete(now_s)
            return None
        self._complete_s = now_s
        waited_in_queue_s = time.time() - buffer.get_system_timestamp() / 1e9
        arrived_s = now_s - max(0.0, waited_in_queue_s)
        stamp_s = buffer.get_timestamp() / 1e9
        moment_s = self._clock.moment_s(Arrival(arrived_s, now_s - asked_s, stamp_s, None, 0.0))
        if moment_s is None:
            return None
        self._ahead_s = stamp_s - moment_s
        return Exposure(picture, self._number, round(1e6 * stamp_s), moment_s, self._exposure_us(buffer))

    def _exposure_us(self, buffer: Any) -> float:
        """Exposure time as the camera sends it with the picture, else as it was set."""
        if self._chunks is not None and buffer.has_chunks():
            try:
                return float(self._chunks.get_float_value(buffer, f"Chunk{EXPOSURE_CHUNK}"))
            except GLib.Error:
                return math.nan
        return self._settings.exposure_us

    def _count(self, frame_id: int) -> bool:
        """Number the picture, those before it that never came included; False for one that a later one overtook."""
        if self._last_id is not None:
            step = frame_id - self._last_id
            step = step % LAST_16_BIT_ID if step <= 0 else step
            if step == 0 or LAST_16_BIT_ID // 2 < step < LAST_16_BIT_ID:
                return False
            self._number += step
        self._last_id = frame_id
        return True

    def _refuse_incomplete(self, now_s: float) -> None:
        lasting_s = now_s - self._complete_s
        if lasting_s > INCOMPLETE_TIME_S:
            raise CameraError(
                f"{self._name}: every picture for {lasting_s:.0f} s came incomplete ({self._incomplete} so far); "
                "check the network card's packet size (jumbo frames) and its receive buffers"
            )

    def _picture(self, buffer: Any) -> SentPicture | None:
        """Picture of a buffer; None where it is shorter than its size, as after packets of another length."""
        kind = np.uint8 if self._coding.bits == 8 else np.dtype("<u2")
        codes: NDArray[Any] = np.frombuffer(bytes(buffer.get_data()), kind)
        shape = buffer.get_image_height(), buffer.get_image_width()
        if codes.size < shape[0] * shape[1]:
            return None
        return sent_picture(codes[: shape[0] * shape[1]].reshape(shape), self._coding)


def _device_of(serial: str) -> str:
    there = connected()
    for camera in there:
        if camera.serial == serial:
            return camera.device
    seen = ", ".join(camera.serial for camera in there) or "none"
    raise CameraError(
        f"no camera {serial} answers; there are: {seen}; check cable and power, and the address's network"
    )


def _path_bytes(address: str) -> int:
    """Largest packet to an address, as this computer's cards have it (ip(7), IP_MTU)."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect((address, CONTROL_PORT))
        return probe.getsockopt(socket.IPPROTO_IP, IP_MTU)


def _coding(pixel_format: str) -> Coding:
    """Coding of a format by its name in the PFNC, as in Mono12 and BayerRG8."""
    if pixel_format.startswith("Mono"):
        return Coding("grey", bits=int(pixel_format.removeprefix("Mono")))
    tile = pixel_format.removeprefix("Bayer")
    return Coding("mosaic", bits=int(tile[2:]), mosaic=MOSAICS[tile[:2]])


def _sentence(error: Any) -> str:
    return str(error.message).strip().rstrip(".")
