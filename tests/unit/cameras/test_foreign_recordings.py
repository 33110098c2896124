"""Recordings as other programs leave them: formats, names, turned pictures, videos without a length, jumps."""

import struct
from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from appliance.cameras.recording.names import stretch_starts
from appliance.cameras.recording.pairs import Recording, RecordingSource
from appliance.cameras.recording.picture_file import read_picture
from appliance.cameras.recording.pictures import PictureRecording, PictureRecordingSource
from appliance.cameras.recording.video_file import VideoFile
from appliance.cameras.source import CameraError
from appliance.conformity.bar_statistics import BarStatistics
from appliance.sizing.station import to_message
from vision.readings import SizeReading

RNG = np.random.default_rng(3)
GREY = RNG.integers(0, 256, (48, 64), dtype=np.uint8)
GREY_12 = RNG.integers(0, 4096, (48, 64)).astype(np.uint16)
GREY_16 = RNG.integers(0, 65536, (48, 64)).astype(np.uint16)
COLOUR = RNG.integers(0, 256, (48, 64, 3), dtype=np.uint8)


def pgm(codes, greatest):
    """Netpbm's plain layout (pgm(5)): written here, not by the library that reads it."""
    kind = ">u2" if greatest > 255 else "u1"
    rows, columns = codes.shape
    return f"P5\n# a camera\n{columns} {rows}\n{greatest}\n".encode() + codes.astype(kind).tobytes()


def tiff(codes, pages=1):
    """TIFF 6.0 without compression, little-endian, directories before the pictures."""
    rows, columns = codes.shape
    bits = 8 * codes.itemsize
    size = 2 + 12 * 8 + 4
    data = b"II*\0" + struct.pack("<I", 8)
    first = 8 + pages * size
    for page in range(pages):
        tags = {256: columns, 257: rows, 258: bits, 259: 1, 262: 1, 273: first, 278: rows, 279: codes.nbytes}
        entries = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags.items())
        after = 8 + (page + 1) * size if page + 1 < pages else 0
        data += struct.pack("<H", len(tags)) + entries + struct.pack("<I", after)
    return data + codes.astype(f"<u{codes.itemsize}").tobytes()


FILES = {
    "png": (cv2.imencode(".png", GREY)[1].tobytes(), GREY, 8),
    "TIF": (tiff(GREY), GREY, 8),
    "tiff": (tiff(GREY_16), GREY_16, 16),
    "bmp": (cv2.imencode(".bmp", COLOUR)[1].tobytes(), COLOUR, 8),
    "PGM": (pgm(GREY, 255), GREY, 8),
    "pgm": (pgm(GREY_12, 4095), GREY_12, 12),
}


@pytest.mark.parametrize("suffix", FILES)
def test_a_picture_of_every_format_has_its_code_values_and_bits(suffix, tmp_path):
    data, codes, bits = FILES[suffix]
    path = tmp_path / f"000000.{suffix}"
    path.write_bytes(data)
    picture = read_picture(path)
    assert np.array_equal(picture.measured if codes.ndim == 3 else picture.measured[:, :, 0], codes)
    assert picture.coding.bits == bits
    assert picture.coding.compression == "none"
    assert len(PictureRecording(tmp_path)) == 1


@pytest.mark.parametrize("suffix", FILES)
@pytest.mark.parametrize("share", [0.02, 0.5, 0.98])
def test_a_picture_that_breaks_off_is_refused_in_one_sentence(suffix, share, tmp_path, capfd):
    path = tmp_path / f"000000.{suffix}"
    data = FILES[suffix][0]
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(CameraError, match="copy or record it again"):
        read_picture(path)
    assert capfd.readouterr().err == ""  # nothing that the library says beside


def test_floating_point_and_several_pictures_in_a_file_are_refused(tmp_path):
    path = tmp_path / "000000.tiff"
    path.write_bytes(cv2.imencode(".tiff", GREY.astype(np.float32))[1].tobytes())
    with pytest.raises(CameraError, match="of 8 to 16 bits"):
        read_picture(path)
    path.write_bytes(tiff(GREY, pages=2))
    with pytest.raises(CameraError, match="holds more than one picture; write each to a file of its own"):
        read_picture(path)


TURNS = {1: 0, 3: 2, 6: 3, 8: 1}  # EXIF orientation: quarter turns against the clock that show it upright (Exif 2.32)


@pytest.mark.parametrize("orientation", TURNS)
@pytest.mark.parametrize("subsampled", [False, True])
def test_a_turned_photograph_is_turned_as_viewers_show_it(orientation, subsampled, tmp_path):
    scene = np.zeros((48, 64, 3), np.uint8)
    scene[:16, :16] = 255
    factor = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420 if subsampled else cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444
    jpeg = cv2.imencode(".jpg", scene, [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, factor])[1].tobytes()
    tag = b"MM\0*" + struct.pack(">IHHHIHHI", 8, 1, 0x0112, 3, 1, orientation, 0, 0)
    exif = b"Exif\0\0" + tag
    marked = jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + jpeg[2:]
    path = tmp_path / "000000.jpg"
    path.write_bytes(marked)
    picture = read_picture(path)
    upright = np.rot90(scene, TURNS[orientation])
    for shown in (picture.shown[..., 0], picture.measured[..., 0]):
        assert shown.shape == upright.shape[:2]
        assert np.abs(shown.astype(int) - upright[..., 0]).mean() < 8


def write_video(path, frames=6, size=(64, 48), codec="ffv1", layout="gray", **options):
    with av.open(str(path), "w", **options) as container:
        stream = container.add_stream(codec, rate=25)
        stream.width, stream.height, stream.pix_fmt = *size, layout
        for number in range(frames):
            codes = np.full(size[::-1], 20 + 30 * number, np.uint8)
            codes[: size[1] // 3, : size[0] // 3] = 250
            frame = av.VideoFrame.from_ndarray(codes, format="gray").reformat(format=layout)
            frame.pts, frame.time_base = number, Fraction(1, 25)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def test_a_video_of_which_the_recorder_was_cut_off_has_all_its_frames(tmp_path):
    """Matroska written to a pipe (live) states neither length nor number of frames."""
    path = write_video(tmp_path / "left.MKV", options={"live": "1"}, format="matroska")
    with av.open(str(path)) as container:
        assert not container.streams.video[0].frames
        assert not container.duration
    (tmp_path / "RIGHT.mkv").write_bytes(path.read_bytes())
    recording = Recording(tmp_path)
    assert len(recording) == 6
    assert [round(float(np.median(left.shown))) for _, left, _ in recording] == [20, 50, 80, 110, 140, 170]


ROTATED = {0: (1, 0, 0, 1), 90: (0, 1, -1, 0), 180: (-1, 0, 0, -1), 270: (0, -1, 1, 0)}  # clockwise, a b c d
CLOCKWISE = {0: 0, 90: 3, 180: 2, 270: 1}  # in quarter turns against the clock


@pytest.mark.parametrize("degrees", ROTATED)
def test_a_turned_video_is_turned_as_players_show_it(degrees, tmp_path):
    """The matrix of the track's header (ISO/IEC 14496-12, 8.3.2), written into the file by hand."""
    path = write_video(tmp_path / "video.mov", codec="mpeg4", layout="yuv420p")
    data = bytearray(path.read_bytes())
    place = data.index(b"tkhd") + 4 + 4 + 8 + 4 + 4 + 4 + 8 + 8
    assert struct.unpack_from(">9i", data, place) == (65536, 0, 0, 0, 65536, 0, 0, 0, 1 << 30)
    a, b, c, d = (65536 * number for number in ROTATED[degrees])
    struct.pack_into(">9i", data, place, a, b, 0, c, d, 0, 0, 0, 1 << 30)
    path.write_bytes(data)
    picture = VideoFile(path).read(0)
    scene = np.full((48, 64), 20)
    scene[:16, :21] = 250
    upright = np.rot90(scene, CLOCKWISE[degrees])
    assert picture.shown.shape[:2] == upright.shape
    assert np.abs(picture.shown.mean(axis=2) - upright).mean() < 15


@pytest.mark.parametrize("suffix", [".mp4", ".MKV", ".avi", ".MOV"])
def test_a_single_video_is_a_recording_of_one_camera(suffix, tmp_path):
    codec, layout = ("mpeg4", "yuv420p") if suffix in {".mp4", ".MOV"} else ("ffv1", "gray")
    path = write_video(tmp_path / f"line 3{suffix}", codec=codec, layout=layout)
    for place in (tmp_path, path):
        recording = PictureRecording(place)
        assert len(recording) == 6
        levels = [float(np.median(picture.shown)) for _, picture in recording]
        assert levels == pytest.approx([20, 50, 80, 110, 140, 170], abs=4)


def named(folder, names, picture=GREY):
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        cv2.imwrite(str(folder / name), picture)
    return folder


@pytest.mark.parametrize(
    ("names", "numbers"),
    [
        (["frame_000007.png", "frame_000009.png"], [7, 9]),
        (["img-9.tif", "img-10.tif", "img-11.tif"], [9, 10, 11]),
        (["cam2 (3).png", "cam2 (12).png"], [3, 12]),
        (["Image3.PNG", "image4.png"], [3, 4]),
        (["000001.png", "._000001.png", ".DS_Store.png"], [1]),
        (["2026-11-29_08-13-07.250.png", "2026-11-29_08-13-08.000.png"], [1795939987250000, 1795939988000000]),
    ],
)
def test_pictures_are_numbered_by_what_changes_in_their_names(names, numbers, tmp_path):
    assert list(PictureRecording(named(tmp_path, names)).numbers) == numbers


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (
            ["first.png"],
            "first.png: the name is not a frame number; name pictures by one number that counts the frames",
        ),
        (["a1.png", "b2.png"], "a1.png and b2.png are not named after one pattern"),
        (["run1_5.png", "run2_6.png"], "2 numbers change between run1_5.png and run2_6.png"),
        (["1.png", "01.png"], "1.png: a second picture of frame 1, as 01.png; remove one"),
    ],
)
def test_names_that_say_no_order_are_refused_with_what_was_seen_and_is_wanted(names, said, tmp_path):
    with pytest.raises(CameraError) as raised:
        PictureRecording(named(tmp_path, names))
    assert said in str(raised.value)


@pytest.mark.parametrize(
    "names",
    [
        ["left/000001.png", "right/000001.png"],
        ["Left/frame1.png", "RIGHT/frame01.png"],
        ["left_0001.png", "right_0001.png"],
        ["0001_L.png", "0001_R.png"],
        ["leftImg_1.bmp", "rightImg_1.bmp"],
    ],
)
def test_two_cameras_are_told_by_their_folders_or_by_their_names(names, tmp_path):
    for level, name in enumerate(names):
        named((tmp_path / name).parent, [(tmp_path / name).name], np.full((8, 8), 50 + 50 * level, np.uint8))
    ((number, left, right),) = Recording(tmp_path)
    assert number == 1
    assert int(left.shown[0, 0]), int(right.shown[0, 0]) == (50, 100)


def test_a_folder_that_is_no_recording_says_what_was_seen(tmp_path):
    named(tmp_path / "cam0", ["1.png"])
    (tmp_path / "notes.txt").write_text("")
    for open_it, wanted in ((Recording, "two"), (PictureRecording, "one")):
        with pytest.raises(
            CameraError, match=rf"\(seen: cam0, notes.txt\); give the folder of a recording of {wanted}"
        ):
            open_it(tmp_path)


@pytest.mark.parametrize(
    ("moments", "starts"),
    [
        ([1, 2, 3, 4], []),
        ([0, 10, 20, 30], []),
        ([1, 2, 3, 5, 6], []),  # one picture lost
        ([1, 2, 3, 40, 41, 42], [3]),
        ([1, 2, 3, 1, 2, 3], [3]),
        ([0, 33333, 66666, 99999, 5_000_000, 5_033_333], [4]),
        ([7], []),
        ([], []),
    ],
)
def test_a_jump_begins_another_stretch(moments, starts):
    assert stretch_starts(moments) == starts


def bars_of(source, count):
    """Bars that the PLC would count, if every picture of a source showed one."""
    bars = BarStatistics(gap_s=0.5)
    with source:
        for _ in range(count):
            exposed = source.next(1.0)
            reading = SizeReading(diameter_mm=100.0)
            bars.add(to_message([reading], exposed, 1.0, slots=(), dropped=0, simulated=True))
    return bars.values()["bar_sequence"]


def write_pairs(folder, numbers):
    for side in ("left", "right"):
        named(folder / side, [f"{number:06}.png" for number in numbers])
    return folder


def test_every_lap_of_a_loop_and_every_jump_begins_a_new_bar(tmp_path):
    steady = write_pairs(tmp_path / "steady", range(6))
    assert bars_of(RecordingSource(steady, rate_hz=0, loop=True), 6) == 1
    assert bars_of(RecordingSource(steady, rate_hz=0, loop=True), 15) == 3
    jumps = write_pairs(tmp_path / "jumps", [0, 1, 2, 3, 400, 401, 402])
    assert bars_of(RecordingSource(jumps, rate_hz=0, loop=True), 7) == 2
    assert bars_of(RecordingSource(jumps, rate_hz=0, loop=True), 14) == 4


def test_a_jump_of_the_time_stamps_begins_a_new_bar(tmp_path):
    folder = write_pairs(tmp_path, range(6))
    stamps = [0, 100_000, 200_000, 9_000_000, 9_100_000, 9_200_000]
    rows = [f"{number},{stamp},{stamp}" for number, stamp in enumerate(stamps)]
    (folder / "timestamps.csv").write_text("\n".join(["frame,left_us,right_us", *rows]))
    assert bars_of(RecordingSource(folder, rate_hz=0, loop=False), 6) == 2


def test_one_camera_loops_into_another_stretch(tmp_path):
    with PictureRecordingSource(named(tmp_path, ["0.png", "1.png"]), rate_hz=0, loop=True) as source:
        assert [source.next(1.0).stretch for _ in range(5)] == [0, 0, 1, 1, 2]
