"""Whether a decoded picture is whole, from what demultiplexer and decoder say.

FFmpeg fills what is lost of a picture from its neighbours and hands it out like any other, and all pictures that build
on it are wrong too. Decoders say so in messages only, some of them at the level of debugging.
"""

import logging
from collections.abc import Sequence
from typing import TypeAlias

import av
import av.logging
from av.video.stream import VideoStream

HARMLESS_SOURCES = {"swscaler"}
TELLING_WORDS = ("concealing", "Frame num gap")  # of the H.264 decoder, below the level of a warning

Message = tuple[int, str, str]
VideoPacket: TypeAlias = "av.Packet[VideoStream]"  # generic for type checkers only


def catch_messages() -> None:
    """Have FFmpeg's messages go to the `av.logging.Capture` of their thread, and nowhere else."""
    logger = logging.getLogger("libav")
    logger.propagate = False
    if not logger.handlers:  # a stream that is opened again would add one more each time
        logger.addHandler(logging.NullHandler())
    av.logging.set_skip_repeated(False)
    av.logging.set_level(av.logging.DEBUG)


class WholePictures:
    """Follows a stream's packets: after any damage nothing is whole before the next key picture.

    Attributes
    ----------
    damaged : int
        Packets whose pictures were not whole.
    last_message : str
        What was said last of damage; empty for nothing.
    """

    def __init__(self) -> None:
        self._from_pts: int | None = None
        self.damaged = 0
        self.last_message = ""

    def follow(self, packet: VideoPacket, frames: Sequence[av.VideoFrame], messages: Sequence[Message]) -> None:
        """Note a packet, what was decoded of it, and what was said meanwhile.

        Parameters
        ----------
        packet : av.Packet
        frames : sequence of av.VideoFrame
        messages : sequence of (int, str, str)
            Level, source and text.
        """
        told = [text.strip() for level, source, text in messages if _tells_damage(level, source, text)]
        if told:
            self.last_message = told[-1]
        if told or packet.is_corrupt or any(frame.is_corrupt for frame in frames):
            self._from_pts = None
        elif self._from_pts is None and packet.is_keyframe and packet.pts is not None:
            self._from_pts = packet.pts
        self.damaged += self._from_pts is None

    def holds(self, frame: av.VideoFrame) -> bool:
        """Whether this picture, decoded of the packet that was noted last, is whole."""
        return self._from_pts is not None and frame.pts is not None and frame.pts >= self._from_pts


def _tells_damage(level: int, source: str, text: str) -> bool:
    if source in HARMLESS_SOURCES:
        return False
    return level <= av.logging.WARNING or any(words in text for words in TELLING_WORDS)
