"""Files as cameras write them, made by the mill, read by the product: luma, range, depth and mosaic come as sent."""

import io
import json

import av
import cv2
import numpy as np
import pytest
from coded_pictures import through_video

from appliance.cameras.recording.jpeg_header import read_jpeg_header
from appliance.cameras.recording.pairs import Recording
from appliance.cameras.recording.picture_file import UNTOLD, ToldCoding, decoded_picture, read_told_coding
from appliance.cameras.recording.video_file import VideoFile
from appliance.cameras.source import CameraError
from appliance.simulation.coding import deep_png, filtered, jpeg, mosaic
from appliance.simulation.video_coding import Video
from vision.sent_picture import LUMA_601, LUMA_709

BLUE_GREEN_RED = (0.114, 0.587, 0.299)


@pytest.fixture(scope="module")
def picture():
    """A red-hot edge, blurred, beside a dark ground."""
    columns = np.arange(64)
    share = 1 / (1 + np.exp(-(columns - 30.9) / 0.3))
    light = np.array([0.01, 0.01, 0.01]) + share[None, :, None] * np.array([0.05, 0.2, 0.6])
    return np.broadcast_to(np.rint(255 * light ** (1 / 2.2)), (48, 64, 3)).astype(np.uint8).copy()


@pytest.mark.parametrize("quality", [50, 75, 90, 95])
@pytest.mark.parametrize("subsampling", ["4:4:4", "4:2:0"])
def test_a_jpeg_header_tells_subsampling_and_quality(picture, quality, subsampling):
    header = read_jpeg_header(jpeg(picture, quality, subsampling))
    assert header == (3, subsampling == "4:2:0", pytest.approx(quality, abs=1), picture.shape[1::-1])


def test_a_grey_jpeg_has_one_component(picture):
    assert read_jpeg_header(jpeg(picture[:, :, 2], 90)).components == 1


def test_luma_of_a_subsampled_jpeg_keeps_the_edge_that_red_loses(picture):
    sent = decoded_picture(jpeg(picture, 95, "4:2:0"))
    assert (sent.coding.samples, sent.coding.compression) == ("luma", "jpeg")
    luma = picture @ np.array(BLUE_GREEN_RED)
    edge = slice(26, 38)
    assert np.abs(sent.measured[:, edge, 0] - luma[:, edge]).max() < 6
    assert np.abs(sent.shown[:, edge, 2].astype(float) - picture[:, edge, 2]).max() > 10


def test_a_whole_jpeg_is_measured_in_its_colours(picture):
    assert decoded_picture(jpeg(picture, 95, "4:4:4")).measured.shape == picture.shape


def test_deep_pictures_say_how_many_bits_count():
    values = np.arange(48 * 64, dtype=np.uint16).reshape(48, 64) + 900
    right = decoded_picture(deep_png(values, 12))
    assert right.coding.bits == 12
    assert np.array_equal(right.measured[:, :, 0], values)
    left = decoded_picture(deep_png(values << 4, 12))  # at the top of 16 bits, as the standard has it
    assert np.array_equal(left.measured, right.measured)
    assert np.array_equal(left.shown, right.shown)


def test_what_a_file_cannot_say_is_told(tmp_path):
    values = np.full((8, 8), 2000, np.uint16)
    data = cv2.imencode(".png", values)[1].tobytes()
    assert decoded_picture(data).coding.bits == 16
    told = decoded_picture(data, ToldCoding(12, "GRBG"))
    assert (told.coding.bits, told.coding.mosaic) == (12, "GRBG")
    assert read_told_coding(tmp_path) == UNTOLD
    (tmp_path / "coding.json").write_text('{"bits": 12, "mosaic": "GRBG"}')
    assert read_told_coding(tmp_path) == ToldCoding(12, "GRBG")


@pytest.mark.parametrize("text", ['{"bits": 7}', '{"mosaic": "RGBG"}', '{"depth": 12}', "[1]", "{"])
def test_a_coding_that_makes_no_sense_is_refused_by_its_file(tmp_path, text):
    (tmp_path / "coding.json").write_text(text)
    with pytest.raises(CameraError, match=r"coding\.json"):
        read_told_coding(tmp_path)


@pytest.mark.parametrize("matrix", ["601", "709"])
@pytest.mark.parametrize("full_range", [False, True])
@pytest.mark.parametrize("bits", [8, 10])
def test_a_video_gives_the_luma_that_was_sent(picture, matrix, full_range, bits):
    video = Video(0 if bits == 8 else 4, bits=bits, full_range=full_range, matrix=matrix)
    sent = through_video([picture], video)
    coding = sent.coding
    assert (coding.samples, coding.bits, coding.full_range) == ("luma", bits, full_range)
    assert coding.luma_weights == (LUMA_709 if matrix == "709" else LUMA_601)
    assert np.abs(sent.measured[:, :, 0] - video.planes(picture)[0]).max() <= (0 if bits == 8 else 12)


@pytest.mark.parametrize(("quantiser", "bits"), [(18, 8), (28, 8), (23, 10)])
def test_an_h264_picture_tells_its_quantiser(picture, quantiser, bits):
    coding = through_video([picture] * 3, Video(quantiser, bits=bits)).coding
    assert coding.quantiser == pytest.approx(quantiser, abs=3)


def test_a_video_of_whole_colours_is_measured_in_them(picture):
    assert through_video([picture], Video(4, subsampling="4:4:4")).coding.samples == "colour"


def test_a_video_file_is_read_frame_by_frame(tmp_path):
    levels = [np.full((48, 64, 3), 20 + 20 * number, np.uint8) for number in range(5)]
    for side in ("left", "right"):
        (tmp_path / f"{side}.mkv").write_bytes(Video(10).encoded(levels))
    recording = Recording(tmp_path)
    assert len(recording) == 5
    shown = [float(left.shown.mean()) for _, left, _ in recording]
    assert shown == pytest.approx([20, 40, 60, 80, 100], abs=2)
    assert VideoFile(tmp_path / "left.mkv").read(7) is None


def test_a_recordings_told_coding_holds_for_its_pictures(tmp_path):
    for side in ("left", "right"):
        (tmp_path / side).mkdir()
        cv2.imwrite(str(tmp_path / side / "000000.png"), np.full((8, 8), 4000, np.uint16))
    (tmp_path / "coding.json").write_text(json.dumps({"bits": 12}))
    _, left, _ = next(iter(Recording(tmp_path)))
    assert left.coding.bits == 12
    assert left.shown.min() == 250


def test_the_mill_writes_what_it_says(picture):
    with av.open(io.BytesIO(Video(20, full_range=True, matrix="601").encoded([picture]))) as container:
        frame = next(container.decode(video=0))
    assert (frame.format.name, int(frame.color_range), int(frame.colorspace)) == ("yuvj420p", 2, 6)


def test_a_mosaic_has_each_channel_at_its_sites(picture):
    sites = mosaic(picture, "GRBG")
    assert np.array_equal(sites[::2, ::2], picture[::2, ::2, 1])
    assert np.array_equal(sites[::2, 1::2], picture[::2, 1::2, 2])
    assert np.array_equal(sites[1::2, ::2], picture[1::2, ::2, 0])


def test_sharpening_overshoots_and_smoothing_does_not(picture):
    red = picture[24, :, 2].astype(int)
    assert filtered(picture, 0.8)[24, :, 2].max() > red.max() + 3
    assert np.diff(filtered(picture, -0.8)[24, :, 2].astype(int)).max() < np.diff(red).max()
