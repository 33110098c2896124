"""One stream and the thread that reads it: every picture is received as it comes, so that none waits unseen."""

import contextlib
import logging
import math
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import av
import av.logging
from av.container import InputContainer
from av.error import ExitError, FFmpegError

from appliance.cameras.pairing import Exposure
from appliance.cameras.picture_clock import Arrival, CameraClock, PresentationClock, RhythmClock, StreamClock
from appliance.cameras.recording.video_file import QUANTISERS, QuantiserWatch, picture_of_frame
from appliance.cameras.source import CameraError
from appliance.cameras.stream.address import with_credentials
from appliance.cameras.stream.damage import Message, VideoPacket, WholePictures, catch_messages

OPEN_TIME_S = 8.0
READ_TIME_S = 3.0  # a network camera that sends nothing for so long is gone
FIRST_TIME_S = 20.0  # from opening to the first picture whose moment is known
DAMAGED_TIME_S = 12.0  # without a whole picture; key pictures come at least every 10 s
END_TIME_S = 1.0  # beyond what reading may take, for a thread to end
DEVICE_FOLDER = "/dev/"
WITHOUT_TIMES = "mpjpeg"  # FFmpeg's name of JPEG pictures over HTTP
REFERENCE_TIME = "prft"  # FFmpeg's name of the moment on the sender's clock, µs since 1970, from RTCP
LOW_DELAY = 1 << 19  # AV_CODEC_FLAG_LOW_DELAY: pictures are handed out as soon as they are decoded
NETWORK_OPTIONS = {"fflags": "nobuffer", "analyzeduration": "300000"}  # µs of stream that are looked at first
REORDERING_US = "100000"  # that a missing packet is waited for, over UDP
# Over TCP packets cannot change places, but a camera under load leaves some out. FFmpeg reports them only where it
# waits for late ones, by default not over TCP: a key picture whose end is missing then passes for a whole one.
TCP_REORDERING_PACKETS = "2"  # least with which it looks; the packet after a gap waits for one more

logger = logging.getLogger("hotgauge.cameras")


class StreamPlace(NamedTuple):
    """Where a stream is and how it is received.

    Attributes
    ----------
    address : str
        Without user and password.
    credentials : Path or None
        File with both.
    transport : {"tcp", "udp"}
        Of RTP packets.
    camera_clock : bool
        Whether the camera's own clock tells a picture's moment.
    delay_s : float
        Time from exposure to arrival.
    """

    address: str
    credentials: Path | None
    transport: str
    camera_clock: bool
    delay_s: float


class _Picture(NamedTuple):
    """A decoded picture that is whole, and whose moment is known."""

    frame: av.VideoFrame
    quantiser: float | None
    number: int
    moment_s: float


class StreamReader:
    """One stream; `news` is notified of every picture.

    Parameters
    ----------
    place : StreamPlace
    news : threading.Condition
    """

    def __init__(self, place: StreamPlace, news: threading.Condition) -> None:
        self._place = place
        self._news = news
        self._newest: _Picture | None = None
        self._trouble: CameraError | None = None
        self._closed = False
        catch_messages()
        # a thread that hangs in native code must not keep the process
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def wait_for_first(self) -> None:
        """Wait until there is a picture to take; raises `CameraError` when none comes."""
        with self._news:
            self._news.wait_for(lambda: self._newest or self._trouble, FIRST_TIME_S)
            self.check()
            if self._newest is None:
                raise CameraError(f"{self._place.address}: no picture within {FIRST_TIME_S:g} s; check the camera")

    def take(self) -> Exposure | None:
        """Newest picture not taken yet."""
        picture, self._newest = self._newest, None
        if picture is None:
            return None
        moment_s = picture.moment_s
        return Exposure(
            picture_of_frame(picture.frame, picture.quantiser),
            picture.number,
            round(1e6 * moment_s),
            moment_s,
            exposure_us=math.nan,
        )

    def check(self) -> None:
        """Raise `CameraError` when the camera is gone."""
        if self._trouble is not None:
            raise self._trouble

    def ask_to_end(self) -> None:
        """Have the thread end at the next picture, or when reading times out."""
        self._closed = True

    def wait_for_end(self) -> None:
        """Wait until the thread has ended, and with it the connection."""
        self._thread.join(READ_TIME_S + END_TIME_S)

    def _run(self) -> None:
        try:
            with av.logging.Capture() as messages:
                self._read(messages)
        except CameraError as error:
            self._report(CameraError(f"{self._place.address}: {error}", error.fault))
        except FFmpegError as error:
            self._report(CameraError(f"{self._place.address}: {_lost(error)}; check camera and network"))
        except Exception as error:  # a mistake of our own, or of the library: told, and the camera is opened again
            logger.exception("%s: reading", self._place.address)
            self._report(
                CameraError(
                    f"{self._place.address}: reading failed ({type(error).__name__}); send the log to the maker"
                )
            )

    def _read(self, messages: list[Message]) -> None:
        with contextlib.closing(self._open()) as container:
            pictures = _Pictures(container, self._clock(container), messages)
            for picture in pictures:
                if self._closed:
                    return
                if picture is not None:
                    self._deliver(picture)
        raise CameraError("the stream has ended; check camera and network")

    def _open(self) -> InputContainer:
        place = self._place
        timeout = (OPEN_TIME_S, READ_TIME_S)
        try:
            if place.address.startswith(DEVICE_FOLDER):
                return av.open(place.address, format="video4linux2", timeout=timeout)
            options = NETWORK_OPTIONS
            if place.address.startswith("rtsp"):
                options = options | {"rtsp_transport": place.transport, "max_delay": REORDERING_US}
                if place.transport == "tcp":
                    options["reorder_queue_size"] = TCP_REORDERING_PACKETS
            return av.open(with_credentials(place.address, place.credentials), options=options, timeout=timeout)
        except FFmpegError as error:  # its own text holds the address with user and password
            raise CameraError(f"cannot be opened ({_reason(error)}); check address, camera and network") from None

    def _clock(self, container: InputContainer) -> StreamClock:
        if self._place.camera_clock:
            return CameraClock()
        kind = RhythmClock if container.format.name == WITHOUT_TIMES else PresentationClock
        return kind(self._place.delay_s)

    def _deliver(self, picture: _Picture) -> None:
        with self._news:
            self._newest = picture
            self._news.notify_all()

    def _report(self, trouble: CameraError) -> None:
        with self._news:
            self._trouble = trouble
            self._news.notify_all()


class _Pictures:
    """Pictures of an open stream that are whole and whose moment is known; None for each packet that gives none."""

    def __init__(self, container: InputContainer, clock: StreamClock, messages: list[Message]) -> None:
        if not container.streams.video:
            raise CameraError("sends no video; check the address")
        self._container = container
        self._stream = container.streams.video[0]
        # one thread: pictures come out as they go in, and what is said of damage is said in this thread
        self._stream.codec_context.thread_count = 1
        self._stream.codec_context.options = QUANTISERS
        self._stream.codec_context.flags |= LOW_DELAY
        self._clock = clock
        self._messages = messages
        self._whole = WholePictures()
        self._whole_s = time.monotonic()
        self._camera_ahead_s: float | None = None
        self._shape: tuple[int, int, str] | None = None
        self._number = 0
        self._quantiser = QuantiserWatch()

    def __iter__(self) -> Iterator[_Picture | None]:
        """Pictures as they come; raises `CameraError` for a changed size or format, a wrong clock, lasting damage."""
        asked_s = time.monotonic()
        for packet in self._container.demux(self._stream):
            arrived_s = time.monotonic()
            frames = packet.decode()
            self._whole.follow(packet, frames, self._messages)
            self._messages.clear()
            for frame in frames:
                yield self._picture(packet, frame, arrived_s, arrived_s - asked_s)
            if not frames:
                yield None
            self._refuse_lasting_damage()
            asked_s = time.monotonic()

    def _picture(self, packet: VideoPacket, frame: av.VideoFrame, arrived_s: float, waited_s: float) -> _Picture | None:
        if not self._whole.holds(frame) or frame.pts is None or frame.time_base is None:
            self._number += self._number > 0
            return None
        self._whole_s = time.monotonic()
        quantiser = self._quantiser.of(frame)
        self._refuse_change(frame)
        presented_s = float(frame.pts * frame.time_base)
        self._follow_camera_time(packet)
        camera_utc_s = None if self._camera_ahead_s is None else presented_s + self._camera_ahead_s
        moment_s = self._clock.moment_s(Arrival(arrived_s, waited_s, presented_s, camera_utc_s, time.time()))
        if moment_s is None:
            self._number += self._number > 0
            return None
        self._number += 1
        return _Picture(frame, quantiser, self._number - 1, moment_s)

    def _follow_camera_time(self, packet: VideoPacket) -> None:
        """Note how far the camera's wall clock is ahead of the presentation time."""
        if packet.pts is None or not packet.has_sidedata(REFERENCE_TIME):
            return
        wall_us = int.from_bytes(bytes(packet.get_sidedata(REFERENCE_TIME))[:8], "little", signed=True)
        self._camera_ahead_s = wall_us / 1e6 - float(packet.pts * packet.time_base)

    def _refuse_change(self, frame: av.VideoFrame) -> None:
        now = (frame.width, frame.height, frame.format.name)
        if self._shape not in {None, now}:
            was_text, now_text = ("{} x {} pixels, {}".format(*shape) for shape in (self._shape or now, now))
            raise CameraError(f"pictures were {was_text}, and are {now_text}", "picture_size_changed")
        self._shape = now

    def _refuse_lasting_damage(self) -> None:
        lasting_s = time.monotonic() - self._whole_s
        if lasting_s > DAMAGED_TIME_S:
            said = f", the decoder says: {self._whole.last_message}" if self._whole.last_message else ""
            raise CameraError(
                f"no whole picture for {lasting_s:.0f} s, {self._whole.damaged} damaged{said}; "
                "check the network, and let the camera send a key picture every second"
            )


def _reason(error: FFmpegError) -> str:
    """What the library says, without the address that it adds."""
    return (error.strerror or "no answer").rstrip(".")


def _lost(error: FFmpegError) -> str:
    if isinstance(error, ExitError):
        return f"no picture for {READ_TIME_S:g} s"
    return f"the stream has ended ({_reason(error)})"
