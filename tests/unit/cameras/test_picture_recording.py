"""A folder of pictures of one camera: order, gaps, broken files, and play at a rate."""

import cv2
import numpy as np
import pytest

from appliance.cameras.recording.pictures import PictureRecording, PictureRecordingSource
from appliance.cameras.source import CameraError, EndOfRecording


def picture(level, size=(48, 64)):
    return np.full((*size, 3), level, np.uint8)


def write_pictures(folder, numbers, suffix=".png"):
    for number in numbers:
        cv2.imwrite(str(folder / f"{number:06}{suffix}"), picture(number))
    return folder


def test_pictures_directly_in_the_folder_come_in_the_order_of_their_numbers(tmp_path):
    (write_pictures(tmp_path, [10, 2, 7]) / "truth.csv").write_text("frame,state\n")
    recording = PictureRecording(tmp_path)
    assert len(recording) == 3
    assert [(number, int(frame.shown[0, 0, 0])) for number, frame in recording] == [(2, 2), (7, 7), (10, 10)]


def test_at_rate_zero_every_picture_comes_until_the_recording_is_over(tmp_path):
    with PictureRecordingSource(write_pictures(tmp_path, range(3)), rate_hz=0, loop=False) as source:
        frames = [source.next(0.0) for _ in range(3)]
        assert [frame.sequence for frame in frames] == [0, 1, 2]
        assert frames[-1].dropped == 0
        assert source.simulated
        with pytest.raises(EndOfRecording, match="is over"):
            source.next(0.0)


def test_a_loop_starts_again_with_the_first_picture_and_goes_on_counting(tmp_path):
    with PictureRecordingSource(write_pictures(tmp_path, range(3)), rate_hz=0, loop=True) as source:
        frames = [source.next(0.0) for _ in range(7)]
    assert [frame.sequence for frame in frames] == list(range(7))
    assert [int(frame.picture[0, 0, 0]) for frame in frames] == [0, 1, 2, 0, 1, 2, 0]


def test_in_real_time_the_newest_picture_wins_and_the_older_ones_are_counted(tmp_path):
    with PictureRecordingSource(write_pictures(tmp_path, range(40)), rate_hz=200, loop=False) as source:
        source.next(1.0)
        source._pacer._start_s -= 0.05  # ten periods pass
        frame = source.next(1.0)
    assert frame.sequence >= 10
    assert frame.dropped == frame.sequence - 1
    assert np.array_equal(frame.picture, picture(frame.sequence))


def test_waiting_ends_at_the_timeout(tmp_path):
    with PictureRecordingSource(write_pictures(tmp_path, range(2)), rate_hz=0.5, loop=False) as source:
        source.next(0.0)
        assert source.next(0.01) is None


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda folder: folder / "nowhere", "nowhere: no such folder"),
        (lambda folder: folder, "holds no pictures"),
        (lambda folder: write_pictures(folder, [1]) / "000001.png", "cannot be read"),
    ],
)
def test_what_is_no_recording_of_one_camera_is_refused_in_one_sentence(tmp_path, make, message):
    with pytest.raises(CameraError, match=message):
        PictureRecording(make(tmp_path))


def test_a_picture_of_another_size_is_refused_with_both_sizes(tmp_path):
    cv2.imwrite(str(write_pictures(tmp_path, range(2)) / "000001.png"), picture(1, (20, 30)))
    with pytest.raises(CameraError, match=r"000001.png: picture is 30 x 20 .* 64 x 48"):
        list(PictureRecording(tmp_path))


def test_a_truncated_picture_is_refused(tmp_path):
    path = write_pictures(tmp_path, [0], ".jpg") / "000000.jpg"
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(CameraError, match="breaks off"):
        PictureRecording(tmp_path).read(0)


def test_the_path_traced_ingot_line_plays(recordings):
    recording = PictureRecording(recordings / "ingot_line" / "seq03")
    assert len(recording) == 80
    assert recording.read(79)[1].shown.shape == (540, 960, 3)
