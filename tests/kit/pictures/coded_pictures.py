"""Pictures of the simulated mill as cameras send them: coded by the mill, decoded by the readers of the product."""

import io
from dataclasses import dataclass

import av
import numpy as np

from appliance.cameras.recording.picture_file import ToldCoding, decoded_picture
from appliance.cameras.recording.video_file import QUANTISERS, QuantiserWatch, picture_of_frame
from appliance.simulation.coding import deep_png, filtered, jpeg, mosaic
from appliance.simulation.video_coding import Video
from vision.sent_picture import SentPicture

PATTERN = "RGGB"
DEEP_BITS = 16


@dataclass(frozen=True)
class CameraCoding:
    """How a camera sends its pictures: `kind` is "png", "jpeg", "mosaic" or a `Video`; `filter` as in `filtered`."""

    kind: object
    bits: int = 8
    quality: int = 90
    subsampling: str = "4:2:0"
    filter: float = 0.0

    def sent(self, pictures):
        """The last of some pictures of one scene, as it arrives; a video needs those before it."""
        if self.filter:
            pictures = [filtered(one, self.filter) for one in pictures]
        if isinstance(self.kind, Video):
            return through_video(pictures, self.kind)
        last = pictures[-1]
        if self.kind == "jpeg":
            return decoded_picture(jpeg(last, self.quality, self.subsampling))
        if self.kind == "mosaic":
            grey = last if last.ndim == 2 else mosaic(last, PATTERN)
            return decoded_picture(deep_png(grey.astype(np.uint16), self.bits), ToldCoding(self.bits, PATTERN))
        return SentPicture.of(last) if self.bits == 8 else decoded_picture(deep_png(last, self.bits))

    @property
    def frames(self):
        return 3 if isinstance(self.kind, Video) else 1


def through_video(pictures, video, *, every=False):
    """The last picture of a video as it arrives, or every one."""
    colours = [one if one.ndim == 3 else np.repeat(one[:, :, None], 3, axis=2) for one in pictures]
    with av.open(io.BytesIO(video.encoded(colours))) as container:
        container.streams.video[0].codec_context.options = QUANTISERS
        watch = QuantiserWatch()
        arrived = [picture_of_frame(frame, watch.of(frame)) for frame in container.decode(video=0)]
    return arrived if every else arrived[-1]


def all_sent(pictures, coding):
    """Every one of a camera's 8-bit pictures as it arrives."""
    if isinstance(coding.kind, Video):
        return through_video(pictures, coding.kind, every=True)
    return [coding.sent([one]) for one in (deep(pictures) if coding.bits == DEEP_BITS else pictures)]


def deep(pictures):
    """Pictures of 16 bits that show the 8-bit ones: what lies between two codes is drawn at random."""
    rng = np.random.default_rng(pictures[0].size)
    return [(257.0 * one + rng.uniform(-128, 128, one.shape)).clip(0, 65535).astype(np.uint16) for one in pictures]


CODINGS = {
    "png": CameraCoding("png"),
    "png smoothed": CameraCoding("png", filter=-0.4),
    "png sharpened": CameraCoding("png", filter=0.6),
    "jpeg 4:2:0 q90 smoothed": CameraCoding("jpeg", filter=-0.4),
    "jpeg 4:2:0 q90 sharpened": CameraCoding("jpeg", filter=0.6),
    "png 12 bit": CameraCoding("png", bits=12),
    "mosaic 8 bit": CameraCoding("mosaic"),
    "mosaic 12 bit": CameraCoding("mosaic", bits=12),
    "jpeg 4:4:4 q90": CameraCoding("jpeg", subsampling="4:4:4"),
    "jpeg 4:2:0 q90": CameraCoding("jpeg"),
    "jpeg 4:2:0 q75": CameraCoding("jpeg", quality=75),
    "h264 crf 18": CameraCoding(Video(18)),
    "h264 crf 23": CameraCoding(Video(23, matrix="601")),
    "h264 crf 23 10 bit": CameraCoding(Video(23, bits=10)),
    "h264 crf 23 full range": CameraCoding(Video(23, full_range=True)),
    "h264 crf 28": CameraCoding(Video(28)),
}
DEEPER_CODINGS = CODINGS | {"png 16 bit": CameraCoding("png", bits=DEEP_BITS)}
