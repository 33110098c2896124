"""Picture files as cameras and people leave them: their nature is their content, and no head is believed blindly."""

import json
import struct
import zlib

import cv2
import numpy as np
import pytest

from appliance.cameras.recording import frames
from appliance.cameras.recording.pairs import Recording
from appliance.cameras.recording.picture_file import read_picture, read_told_coding
from appliance.cameras.recording.time_stamps import read_stamps
from appliance.cameras.source import CameraError

PICTURE = cv2.GaussianBlur(np.random.default_rng(5).integers(0, 255, (60, 80, 3), np.uint8), (0, 0), 3)


def coded(suffix: str) -> bytes:
    return cv2.imencode(suffix, PICTURE)[1].tobytes()


def written(folder, name: str, data: bytes):
    (folder / name).write_bytes(data)
    return folder / name


@pytest.mark.parametrize("tail", [b"", b"\0" * 64, b"SEFT trailer of a telephone", coded(".jpg")])
def test_what_a_camera_writes_after_the_end_of_a_jpeg_does_not_matter(tmp_path, tail):
    picture = read_picture(written(tmp_path, "000000.jpg", coded(".jpg") + tail))
    assert np.array_equal(picture.shown, cv2.imdecode(np.frombuffer(coded(".jpg"), np.uint8), cv2.IMREAD_COLOR))


@pytest.mark.parametrize(("name", "content"), [("000000.jpg", ".png"), ("000000.png", ".jpg")])
def test_a_picture_with_the_suffix_of_another_format_is_read_by_its_content(tmp_path, name, content):
    picture = read_picture(written(tmp_path, name, coded(content)))
    assert picture.coding.compression == ("none" if content == ".png" else "jpeg")
    assert picture.size == (80, 60)


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_a_truncated_picture_is_named_as_such_even_with_a_preview_that_is_whole(tmp_path, suffix):
    data = coded(suffix)
    if suffix == ".jpg":  # a preview in an APP1 segment, as telephones write it
        preview = cv2.imencode(".jpg", PICTURE[::4, ::4])[1].tobytes()
        data = data[:2] + b"\xff\xe1" + struct.pack(">H", 2 + len(preview)) + preview + data[2:]
        assert read_picture(written(tmp_path, "000000.jpg", data)).size == (80, 60)
    with pytest.raises(CameraError, match="breaks off before the picture's end"):
        read_picture(written(tmp_path, f"000001{suffix}", data[: len(data) * 2 // 3]))


def chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def png_of_size(columns: int, rows: int) -> bytes:
    head = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


@pytest.mark.parametrize("size", [(100_000, 100_000), (20_000, 20_000), (2**31 - 1, 2**31 - 1)])
def test_a_few_bytes_that_announce_a_giant_picture_are_refused_before_any_memory_is_taken(tmp_path, size):
    with pytest.raises(CameraError, match=f"announces {size[0]} x {size[1]} pixels"):
        read_picture(written(tmp_path, "000000.png", png_of_size(*size)))


def test_a_jpeg_that_announces_a_giant_picture_is_refused(tmp_path):
    data = bytearray(coded(".jpg"))
    place = data.index(b"\xff\xc0")
    data[place + 5 : place + 9] = struct.pack(">HH", 60_000, 60_000)
    with pytest.raises(CameraError, match="announces 60000 x 60000 pixels"):
        read_picture(written(tmp_path, "000000.jpg", bytes(data)))


@pytest.mark.parametrize("data", [b"", b"GIF89a", png_of_size(0, 0), b"\xff\xd8\xff\xd9", b"\x89PNG\r\n\x1a\n"])
def test_what_is_no_picture_is_named(tmp_path, data):
    with pytest.raises(CameraError, match=r"000000\.png: (not a readable|the file breaks off)"):
        read_picture(written(tmp_path, "000000.png", data))


@pytest.mark.parametrize("text", ["[" * 100_000, '{"bits": 12.0}', '{"bits": true}', '{"bits": [12]}', "7", "\xff"])
def test_a_coding_file_that_says_no_coding_is_named(tmp_path, text):
    (tmp_path / "coding.json").write_text(text, encoding="latin-1")
    with pytest.raises(CameraError, match=r"coding\.json"):
        read_told_coding(tmp_path)


def test_text_files_may_begin_with_a_byte_order_mark(tmp_path):
    (tmp_path / "coding.json").write_bytes(b"\xef\xbb\xbf" + json.dumps({"bits": 12}).encode())
    (tmp_path / "timestamps.csv").write_bytes(b"\xef\xbb\xbfframe,left_us,right_us\n3,10,12\n")
    assert read_told_coding(tmp_path).bits == 12
    stamps = read_stamps(tmp_path)[3]
    assert (stamps.left_us, stamps.right_us, stamps.stamped) == (10, 12, True)


def test_a_folder_that_cannot_be_read_is_a_camera_fault_and_not_the_end_of_the_station(tmp_path, monkeypatch):
    def refuse(folder):
        raise PermissionError(13, "Permission denied", str(folder))

    for side in ("left", "right"):
        (tmp_path / side).mkdir()
    monkeypatch.setattr(frames, "pictures_in", refuse)
    with pytest.raises(CameraError, match=r"left: cannot be read \(Permission denied\)"):
        Recording(tmp_path)


def test_a_jpeg_whose_data_slip_is_refused_and_its_decoder_says_nothing_beside(tmp_path, capfd):
    data = bytearray(coded(".jpg"))
    at = data.index(b"\xff\xda") + 200
    del data[at : at + 300]
    with pytest.raises(CameraError, match="the file is damaged"):
        read_picture(written(tmp_path, "000000.jpg", bytes(data)))
    assert capfd.readouterr() == ("", "")


def test_a_jpeg_that_a_camera_has_filled_up_before_its_end_is_read(tmp_path, capfd):
    data = coded(".jpg")
    picture = read_picture(written(tmp_path, "000000.jpg", data[:-2] + b"\0" * 16 + data[-2:]))
    assert np.array_equal(picture.shown, cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR))
    assert capfd.readouterr().err == ""


def test_a_png_with_one_flipped_bit_is_refused(tmp_path):
    data = bytearray(coded(".png"))
    data[len(data) // 2] ^= 4
    with pytest.raises(CameraError, match="a checksum does not fit"):
        read_picture(written(tmp_path, "000000.png", bytes(data)))
