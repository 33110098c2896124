"""What the ingot station believes of its camera, on the recordings and on pictures that stand still."""

import dataclasses

import pytest

from appliance.cameras.liveness import Exposure, Liveness
from appliance.cameras.recording.pictures import PictureRecordingSource
from appliance.cameras.settings import LivenessSettings


@pytest.mark.parametrize("sequence", ["seq01", "seq02", "seq03", "seq04"])
def test_every_picture_of_a_recorded_ingot_line_counts(recordings, sequence):
    liveness = Liveness(LivenessSettings(), 0.0, numbered=True)
    with PictureRecordingSource(recordings / "ingot_line" / sequence, rate_hz=0, loop=False) as source:
        for _ in range(40):
            frame = source.next(1.0)
            assert liveness.judge(Exposure.from_source(frame), frame.exposed_monotonic_s).counts


def test_a_camera_that_shows_the_same_picture_again_is_frozen(recordings):
    liveness = Liveness(LivenessSettings(), 0.0, numbered=False)
    with PictureRecordingSource(recordings / "ingot_line" / "seq01", rate_hz=0, loop=False) as source:
        frame = source.next(1.0)
    verdicts = [
        liveness.judge(
            Exposure.from_source(dataclasses.replace(frame, exposed_monotonic_s=number * 0.2, device_us=number)),
            number * 0.2,
        )
        for number in range(10)
    ]
    assert not any(verdict.counts for verdict in verdicts)
    assert "camera_frozen" in verdicts[-1].faults
