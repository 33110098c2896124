"""GenICam cameras: Aravis' fake GigE Vision camera on loopback, and its other one, within this process, beside it."""

import contextlib
import itertools
import shutil
import subprocess
import time

import pytest
from running import HOTGAUGE

from appliance.cameras.genicam import device
from appliance.cameras.genicam.device import Aravis, connected
from appliance.cameras.genicam.settings import GenicamCamera, GenicamPictures
from appliance.cameras.genicam.source import GenicamPictureSource, GenicamSource
from appliance.cameras.source import CameraError

pytestmark = pytest.mark.waiting

FAKE = "arv-fake-gv-camera-0.8"
SERIAL = "GV77"
SETTLE_S = 4.0
REGION = [0, 0, 512, 512]


@contextlib.contextmanager
def gige_camera(lost_per_thousand=0):
    assert shutil.which(FAKE), f"{FAKE} is missing; install the Debian package aravis-tools"
    words = [FAKE, "-i", "127.0.0.1", "-s", SERIAL, "-r", str(lost_per_thousand)]
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            until_s = time.monotonic() + 5
            while SERIAL not in {camera.serial for camera in connected()} and time.monotonic() < until_s:
                time.sleep(0.1)
            yield process
        finally:
            process.kill()


@pytest.fixture
def partner():
    """Serial number of a camera within this process."""
    Aravis.enable_interface("Fake")
    yield next(camera.serial for camera in connected() if camera.protocol == "Fake")
    Aravis.disable_interface("Fake")


def pictures_of(**settings):
    given = {"rate_hz": 25.0, "exposure_us": 3000.0, "region": REGION} | settings
    return GenicamPictureSource(GenicamPictures(kind="genicam", serial=SERIAL, **given))


def frames_of(source, seconds):
    until_s = time.monotonic() + seconds
    while time.monotonic() < until_s:
        if (frame := source.next(0.2)) is not None:
            yield frame


@pytest.mark.parametrize("pixel_format", ["Mono8", "Mono16", "BayerRG8", "BayerGB8"])
def test_pictures_carry_their_format_and_are_young(pixel_format):
    with gige_camera(), pictures_of(pixel_format=pixel_format) as source:
        frames = list(frames_of(source, SETTLE_S))
    assert len(frames) > 20
    assert frames[-1].picture.shape[:2] == (512, 512)
    assert (frames[-1].picture.ndim == 3) == pixel_format.startswith("Bayer")
    assert all(earlier.device_us < later.device_us for earlier, later in itertools.pairwise(frames))
    assert frames[-1].exposure_us == 3000.0


def test_the_region_is_what_is_sent():
    with gige_camera(), pictures_of(region=[0, 0, 256, 128]) as source:
        frame = next(frames_of(source, SETTLE_S + 2))
    assert frame.picture.shape == (128, 256)


def test_two_cameras_make_pairs(partner):
    settings = GenicamCamera(
        kind="genicam", left=SERIAL, right=partner, rate_hz=25.0, exposure_us=3000.0, region=REGION
    )
    with gige_camera(), GenicamSource(settings, 20_000) as source:
        pairs = list(frames_of(source, 6))
    apart_us = [abs(pair.left_us - pair.right_us) for pair in pairs]
    assert apart_us[0] < 25_000  # they run freely, at a period of 40 ms; none is left from before both had begun
    assert sum(apart < 25_000 for apart in apart_us) > 60  # `liveness` rejects a pair that a stall has put out of step
    assert [pair.sequence for pair in pairs] == sorted({pair.sequence for pair in pairs})
    assert all(0 <= time.monotonic() - pair.exposed_monotonic_s < 10 for pair in pairs)


def test_pictures_with_lost_packets_are_not_measured_but_counted():
    with gige_camera(lost_per_thousand=1), pictures_of() as source:
        frames = list(frames_of(source, 6))
        complete = frames_are_whole(frames)
    assert complete
    assert frames[-1].sequence + 1 - len(frames) == frames[-1].dropped


def frames_are_whole(frames):
    """The fake camera draws a slope that moves: a line that packets have left out is black."""
    return all(frame.picture.any(axis=1).all() for frame in frames)


def test_a_camera_that_dies_is_told_and_opens_again_when_it_is_back():
    with gige_camera() as process, pictures_of() as source:
        assert next(frames_of(source, 5)).picture.any()
        process.kill()
        with pytest.raises(CameraError, match=f"camera {SERIAL} is gone; check cable and power"):
            list(frames_of(source, 12))
    time.sleep(1)
    with gige_camera(), pictures_of() as source:
        assert next(frames_of(source, 5)).picture.any()


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"pixel_format": "Mono12"}, "does not send Mono12; set one of BayerBG8, .*Mono8"),
        ({"trigger": "Line7"}, "has no trigger Line7; set one of Line0, Software"),
        ({"black_level": 10.0}, "has no black level; leave black_level out"),
    ],
)
def test_a_setting_that_the_camera_has_not_is_one_sentence(settings, match):
    with gige_camera(), pytest.raises(CameraError, match=match):
        pictures_of(**settings).__enter__()


def test_a_camera_that_is_not_there_is_one_sentence_with_those_that_are():
    camera = GenicamPictures(kind="genicam", serial="nobody")
    with gige_camera(), pytest.raises(CameraError, match=f"no camera nobody answers; there are: .*{SERIAL}"):
        GenicamPictureSource(camera).__enter__()


def test_the_cameras_that_are_connected_are_listed_with_what_they_send():
    with gige_camera():
        said = subprocess.run([HOTGAUGE, "cameras"], capture_output=True, text=True, check=True, timeout=60).stdout
    (line,) = (line for line in said.splitlines() if SERIAL in line)
    assert line.startswith(f"genicam  {SERIAL}: Fake, GigEVision 127.0.0.1, 2048 x 2048 pixels, ")
    assert "Mono8" in line
    assert "MTU" in line
    assert {row.split()[0] for row in said.splitlines()} == {"genicam", "oak", "stream"}


@pytest.mark.parametrize(("packet_bytes", "advised"), [(576, True), (1500, True), (1501, False), (8164, False)])
def test_packets_that_any_network_card_takes_come_with_advice_and_jumbo_frames_without(packet_bytes, advised):
    assert ("MTU" in device._packet_hint(packet_bytes)) == advised
