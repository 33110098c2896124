"""The thread that reads a stream: what ends it is told to the station."""

import threading

import pytest

from appliance.cameras.source import CameraError
from appliance.cameras.stream.reader import StreamPlace, StreamReader


def test_a_mistake_in_the_thread_is_a_lost_camera_and_not_silence(monkeypatch):
    def opens(_: StreamReader) -> None:
        raise ValueError("rtsp://user:secret@10.0.0.7/ cannot be read")

    monkeypatch.setattr(StreamReader, "_open", opens)
    reader = StreamReader(StreamPlace("rtsp://10.0.0.7/", None, "tcp", False, 0.0), threading.Condition())
    with pytest.raises(CameraError, match=r"rtsp://10\.0\.0\.7/: reading failed \(ValueError\)") as told:
        reader.wait_for_first()
    assert told.value.fault == "camera_lost"
