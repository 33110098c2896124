"""A recording of pairs: its files, time stamps and videos, broken ones named, and play at a rate."""

import time

import cv2
import numpy as np
import pytest

from appliance.cameras.pacing import Pacer
from appliance.cameras.recording.pairs import Recording, RecordingSource
from appliance.cameras.recording.picture_file import read_picture
from appliance.cameras.recording.time_stamps import FrameMoments, Stamps
from appliance.cameras.source import CameraError, EndOfRecording

SIZE = (48, 64)


def picture(level, shape=(*SIZE, 3)):
    """Noisy enough that its JPEG file is long and can be cut anywhere."""
    noise = np.random.default_rng(level).integers(0, 60, shape, dtype=np.uint8)
    return noise + np.uint8(level)


def write_pictures(folder, numbers, suffix=".png", shape=(*SIZE, 3)):
    for offset, side in enumerate(("left", "right")):
        (folder / side).mkdir(parents=True, exist_ok=True)
        for number in numbers:
            cv2.imwrite(str(folder / side / f"{number:06}{suffix}"), picture(2 * number + offset, shape))
    return folder


def write_videos(folder, counts, suffix=".avi", fourcc="FFV1"):
    for side, count in zip(("left", "right"), counts, strict=True):
        code = cv2.VideoWriter.fourcc(*fourcc)
        writer = cv2.VideoWriter(str(folder / f"{side}{suffix}"), code, 25, SIZE[::-1])
        for number in range(count):
            writer.write(np.full((*SIZE, 3), 20 + 20 * number, np.uint8))
        writer.release()
    return folder


def numbers_of(source, count):
    return [source.next(1.0).sequence for _ in range(count)]


class Clock:
    """Time that passes only by sleeping or on order."""

    def __init__(self):
        self.now_s = 100.0

    def __call__(self):
        return self.now_s

    def sleep(self, seconds):
        self.now_s += seconds


def test_pictures_come_in_the_order_of_their_frame_numbers_and_unchanged(tmp_path):
    recording = Recording(write_pictures(tmp_path, [10, 2, 7]))
    frames = list(recording)
    assert len(recording) == 3
    assert [number for number, _, _ in frames] == [2, 7, 10]
    for number, left, right in frames:
        assert np.array_equal(left.shown, picture(2 * number))
        assert np.array_equal(right.shown, picture(2 * number + 1))


def test_grey_pictures_stay_two_dimensional(tmp_path):
    _, left, right = next(iter(Recording(write_pictures(tmp_path, [0], shape=SIZE))))
    assert left.shown.shape == right.shown.shape == SIZE
    assert left.shown.dtype == np.uint8


@pytest.mark.parametrize(("suffix", "fourcc"), [(".mp4", "mp4v"), (".avi", "MJPG"), (".mkv", "FFV1"), (".mov", "mp4v")])
def test_videos_give_every_frame_once(tmp_path, suffix, fourcc):
    recording = Recording(write_videos(tmp_path, (7, 7), suffix, fourcc))
    frames = list(recording)
    assert len(recording) == 7
    assert [number for number, _, _ in frames] == list(range(7))
    for number, left, right in frames:
        assert abs(float(left.shown.mean()) - (20 + 20 * number)) < 4
        assert abs(float(right.shown.mean()) - (20 + 20 * number)) < 4


def test_a_video_can_be_read_backwards_and_with_gaps(tmp_path):
    recording = Recording(write_videos(tmp_path, (6, 6)))
    levels = [round(float(recording.read(position)[1].shown.mean())) for position in (4, 1, 5, 0)]
    assert levels == [100, 40, 120, 20]


def test_at_rate_zero_every_pair_comes_and_none_is_dropped_until_the_recording_is_over(tmp_path):
    with RecordingSource(write_pictures(tmp_path, range(5)), rate_hz=0, loop=False) as source:
        pairs = [source.next(0.0) for _ in range(5)]
        assert [pair.sequence for pair in pairs] == [0, 1, 2, 3, 4]
        assert pairs[-1].dropped == 0
        assert source.simulated
        with pytest.raises(EndOfRecording, match="is over"):
            source.next(0.0)


@pytest.mark.parametrize("write", [lambda p: write_pictures(p, range(3)), lambda p: write_videos(p, (3, 3))])
def test_a_loop_starts_again_with_the_first_frame_and_goes_on_counting(tmp_path, write):
    with RecordingSource(write(tmp_path), rate_hz=0, loop=True) as source:
        pairs = [source.next(0.0) for _ in range(7)]
    assert [pair.sequence for pair in pairs] == list(range(7))
    for lap in (pairs[3:6], pairs[6:7]):
        for first, again in zip(pairs, lap, strict=False):
            assert np.array_equal(first.left, again.left)


def test_in_real_time_the_newest_pair_wins_and_the_older_ones_are_counted():
    clock = Clock()
    pacer = Pacer(10.0, clock, clock.sleep)
    assert pacer.next_due(1.0) == (0, 100.0)
    clock.now_s += 0.57
    number, moment_s = pacer.next_due(1.0)
    assert number == 5
    assert moment_s == pytest.approx(100.5)
    assert pacer.dropped == 4
    assert pacer.next_due(1.0)[0] == 6
    assert pacer.dropped == 4


def test_waiting_ends_at_the_timeout_and_the_next_pair_is_not_lost():
    clock = Clock()
    pacer = Pacer(2.0, clock, clock.sleep)
    pacer.next_due(1.0)
    assert pacer.next_due(0.2) is None
    assert clock.now_s == pytest.approx(100.2)
    assert pacer.next_due(0.4) == (1, pytest.approx(100.5))
    assert clock.now_s == pytest.approx(100.5)
    assert pacer.dropped == 0


def test_a_negative_rate_is_a_wrong_call():
    with pytest.raises(ValueError, match="rate_hz"):
        Pacer(-1.0)


def test_pictures_skipped_in_real_time_are_counted_in_the_pair(tmp_path):
    with RecordingSource(write_pictures(tmp_path, range(40)), rate_hz=200, loop=False) as source:
        source.next(1.0)
        source._pacer._start_s -= 0.05  # ten periods pass
        pair = source.next(1.0)
    assert pair.sequence >= 10
    assert pair.dropped == pair.sequence - 1
    assert np.array_equal(pair.left, picture(2 * pair.sequence))


def test_without_a_table_device_time_is_the_frame_times_the_period(tmp_path):
    with RecordingSource(write_pictures(tmp_path, range(2)), rate_hz=50, loop=True) as source:
        pairs = [source.next(1.0) for _ in range(3)]
    assert [pair.left_us for pair in pairs] == [pair.sequence * 20_000 for pair in pairs]


def test_device_time_comes_from_the_table_and_goes_on_in_the_next_lap(tmp_path):
    write_pictures(tmp_path, range(3))
    table = "frame,left_us,right_us\n0,1000,1010\n1,2000,2011\n2,3000,3012\n"
    (tmp_path / "timestamps.csv").write_text(table)
    with RecordingSource(tmp_path, rate_hz=0, loop=True) as source:
        stamps = [(pair.left_us, pair.right_us) for pair in (source.next(0.0) for _ in range(5))]
    assert stamps == [(1000, 1010), (2000, 2011), (3000, 3012), (4000, 4010), (5000, 5011)]


@pytest.mark.parametrize(
    "numbers",
    [range(5), [0, 10, 20, 30, 40], [1_764_000_000_000_000 + 33_333 * frame for frame in range(5)]],
    ids=["each", "every tenth", "dates in microseconds"],
)
def test_frames_without_time_stamps_follow_each_other_at_25_a_second(numbers):
    moments = FrameMoments(numbers)
    assert [moments.moment_s(number) for number in numbers] == pytest.approx([0.0, 0.04, 0.08, 0.12, 0.16])


def test_numbers_that_jump_leave_as_much_time_as_frames_are_missing():
    moments = FrameMoments([0, 1, 2, 102])
    assert [moments.moment_s(number) for number in (0, 1, 2, 102)] == pytest.approx([0.0, 0.04, 0.08, 4.08])


def test_a_frame_without_a_time_stamp_among_others_follows_the_frame_before():
    moments = FrameMoments(
        range(4), {number: Stamps(9_000_000 + 40_000 * number, 0, stamped=True) for number in (0, 1, 3)}
    )
    assert [moments.moment_s(number) for number in range(4)] == pytest.approx([9.0, 9.04, 9.08, 9.12])


@pytest.mark.parametrize(
    "table", ["frame,left_us\n0,1\n", "frame,left_us,right_us\n0,one,2\n", "frame,left_us,right_us\n0,1\n", "\x00\n"]
)
def test_a_table_of_time_stamps_that_is_wrong_is_refused(tmp_path, table):
    write_pictures(tmp_path, [0])
    (tmp_path / "timestamps.csv").write_text(table)
    with pytest.raises(CameraError, match=r"timestamps.csv.*"), RecordingSource(tmp_path, 0, loop=False) as source:
        source.next(0.0)


def test_a_frame_without_a_time_stamp_is_named(tmp_path):
    write_pictures(tmp_path, range(2))
    (tmp_path / "timestamps.csv").write_text("frame,left_us,right_us\n0,1,2\n")
    with RecordingSource(tmp_path, 0, loop=False) as source:
        source.next(0.0)
        with pytest.raises(CameraError, match=r"timestamps.csv: no row for frame 1"):
            source.next(0.0)


def test_a_missing_folder_is_named(tmp_path):
    with (
        pytest.raises(CameraError, match="nowhere: no such folder"),
        RecordingSource(tmp_path / "nowhere", 0, loop=True),
    ):
        pass


def test_a_folder_that_is_no_recording_says_what_is_missing(tmp_path):
    (tmp_path / "left").mkdir()
    with pytest.raises(CameraError, match=r"neither left/ and right/ .* nor left.mp4 and right.mp4"):
        Recording(tmp_path)


def test_empty_folders_are_refused(tmp_path):
    with pytest.raises(CameraError, match="hold no pictures"):
        Recording(write_pictures(tmp_path, []))


def test_a_picture_that_stands_alone_is_named(tmp_path):
    write_pictures(tmp_path, range(4))
    (tmp_path / "right" / "000002.png").unlink()
    with pytest.raises(CameraError, match=r"4 left and 3 right pictures .* frame 2"):
        Recording(tmp_path)


def test_a_name_without_a_number_and_a_frame_twice_are_refused(tmp_path):
    write_pictures(tmp_path, range(2))
    (tmp_path / "left" / "000001.jpg").write_bytes(b"")
    with pytest.raises(CameraError, match="second picture of frame 1"):
        Recording(tmp_path)
    (tmp_path / "left" / "000001.jpg").rename(tmp_path / "left" / "first.jpg")
    with pytest.raises(CameraError, match=r"first.jpg: the name is not a frame number"):
        Recording(tmp_path)


@pytest.mark.parametrize("suffix", [".jpg", ".png"])
@pytest.mark.parametrize("kept", [0.0, 0.3, 0.9, 0.999])
def test_a_truncated_picture_is_refused_wherever_it_breaks_off(tmp_path, suffix, kept):
    write_pictures(tmp_path, range(2), suffix)
    path = tmp_path / "right" / f"000001{suffix}"
    data = path.read_bytes()
    path.write_bytes(data[: int(kept * len(data))])
    recording = Recording(tmp_path)
    assert recording.read(0) is not None
    with pytest.raises(CameraError, match=rf"right/000001{suffix}: the file breaks off"):
        recording.read(1)


def test_zeros_that_pad_a_whole_jpeg_do_no_harm(tmp_path):
    write_pictures(tmp_path, [0], ".jpg")
    path = tmp_path / "left" / "000000.jpg"
    before = read_picture(path).shown
    path.write_bytes(path.read_bytes() + bytes(100))
    assert np.array_equal(read_picture(path).shown, before)


def test_a_file_that_is_no_picture_is_refused(tmp_path):
    path = tmp_path / "000000.jpg"
    path.write_bytes(b"not a picture\xff\xd9")
    with pytest.raises(CameraError, match="not a readable"):
        read_picture(path)


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_picture_of_another_size_is_refused_with_both_sizes(tmp_path, side):
    write_pictures(tmp_path, range(2))
    cv2.imwrite(str(tmp_path / side / "000001.png"), np.zeros((20, 30), np.uint8))
    with pytest.raises(CameraError, match=rf"{side}/000001.png: picture is 30 x 20 .* 64 x 48"):
        list(Recording(tmp_path))


def test_videos_of_different_length_are_refused(tmp_path):
    with pytest.raises(CameraError, match=r"left.avi has 5 frames and right.avi 4"):
        Recording(write_videos(tmp_path, (5, 4)))


def test_of_two_videos_of_a_side_both_are_named(tmp_path):
    for name in ("left.mp4", "left.avi", "right.mp4"):
        (tmp_path / name).write_bytes(b"")
    with pytest.raises(CameraError, match=r"more than one left video \(left\.\w+, left\.\w+\); remove all but one"):
        Recording(tmp_path)


def test_a_video_that_cannot_be_opened_is_named(tmp_path):
    write_videos(tmp_path, (3, 3))
    (tmp_path / "right.avi").write_bytes(b"nothing")
    with pytest.raises(CameraError, match=r"right.avi: cannot be opened"):
        Recording(tmp_path)


def test_the_path_traced_recordings_play(recordings):
    recording = Recording(recordings / "line_a" / "scenes" / "s1_clean")
    assert [(number, left.shown.shape) for number, left, _ in recording] == [(0, (1520, 2704, 3)), (1, (1520, 2704, 3))]


def test_a_slow_reader_of_a_loop_sees_all_its_frames(tmp_path):
    seen = set()
    with RecordingSource(write_pictures(tmp_path, range(3)), rate_hz=100, loop=True) as source:
        for _ in range(12):
            pair = source.next(1.0)
            frame = pair.sequence % 3
            assert np.array_equal(pair.left, picture(2 * frame))
            seen.add(frame)
            time.sleep(0.025)
    assert seen == {0, 1, 2}


def test_names_of_videos_in_letters_of_any_case_are_found(tmp_path):
    write_videos(tmp_path, (3, 3))
    (tmp_path / "left.avi").rename(tmp_path / "Left.AVI")
    assert len(Recording(tmp_path)) == 3


def test_hidden_files_beside_the_pictures_are_passed_over(tmp_path):
    write_pictures(tmp_path, range(3))
    (tmp_path / "left" / "._000000.png").write_bytes(b"resource fork")
    assert len(Recording(tmp_path)) == 3
