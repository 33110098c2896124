"""What happens to two fake GigE cameras; each scenario prints one line of JSON. Run by `scenario`.

The fake cameras stamp their pictures with this computer's wall clock, so their true moments are known, although each
camera's clock counts as its own.
"""

import contextlib
import itertools
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from unittest.mock import patch

from appliance.cameras.genicam import device
from appliance.cameras.genicam.device import Aravis, Device, connected
from appliance.cameras.genicam.settings import GenicamCamera
from appliance.cameras.genicam.source import GenicamSource
from appliance.cameras.source import CameraError

FAKE = "arv-fake-gv-camera-0.8"
SERIALS = {"GV01": "127.0.0.1", "GV02": "127.0.0.2"}
LEFT, RIGHT = SERIALS
RATE_HZ = 25.0
PERIOD_US = 1e6 / RATE_HZ
SETTLED_S = 2.0
LOST_WITHIN_S = 30.0
KEPT = 64  # pictures
CLOCK_MARGIN_US = 5_000  # by which the gauge may misjudge a camera's clock
RETRY_S = 1.0  # as the station waits: appliance/sizing/station.py


@contextlib.contextmanager
def fake_camera(serial, lost_per_thousand=0, description=None):
    """A camera's process, once it answers."""
    assert shutil.which(FAKE), f"{FAKE} is missing; install the Debian package aravis-tools"
    words = [FAKE, "-i", SERIALS[serial], "-s", serial, "-r", str(lost_per_thousand)]
    words += ["-g", str(description)] if description else []
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            wait_for(serial)
            yield process
        finally:
            process.kill()


def wait_for(serial, seconds=5):
    until_s = time.monotonic() + seconds
    while serial not in {camera.serial for camera in connected()} and time.monotonic() < until_s:
        time.sleep(0.1)


def settings(**more):
    given = {"rate_hz": RATE_HZ, "exposure_us": 3000.0, "region": [0, 0, 512, 512]}
    return GenicamCamera(kind="genicam", left=LEFT, right=RIGHT, **given | more)


@contextlib.contextmanager
def both(left_lost=0, right_lost=0):
    with fake_camera(LEFT, left_lost) as left, fake_camera(RIGHT, right_lost) as right:
        yield left, right


def pairs_of(source, number, within_s=120.0):
    until_s = time.monotonic() + within_s
    while number and time.monotonic() < until_s:
        if (pair := source.next(0.5)) is not None:
            number -= 1
            yield pair


def note_true_moments():
    """Have devices note the true stamp and the number of each picture that they give, by the picture."""
    given = {}
    take = Device.take

    def noting(device, wait_s):
        exposure = take(device, wait_s)
        if exposure is not None:
            given[id(exposure.picture)] = exposure  # which keeps the picture, so that no other gets its id
            while len(given) > KEPT:
                given.pop(next(iter(given)))
        return exposure

    Device.take = noting
    return given


def pairs(number=1000, apart_max_us=22_000, **more):
    """True distance in time of pairs that count, by their true stamps; a mismatch is one over the limit and a margin.

    Cameras that run freely are half a period apart at most. A pair counts where its moments as the gauge knows them are
    no further apart than `apart_max_us`, as `sizing.liveness.apart_max_us` has it.
    """
    given = note_true_moments()
    apart_us, numbers, refused = [], [], 0
    with both(), GenicamSource(settings(**more), apart_max_us) as source:
        started_s = time.monotonic()
        for pair in pairs_of(source, 10 * number):
            if abs(pair.left_us - pair.right_us) > apart_max_us:
                refused += 1
                continue
            left, right = (given[id(picture)] for picture in pair.sent)
            apart_us.append(abs(left.device_us - right.device_us))
            numbers.append((left.sequence, right.sequence))
            if len(apart_us) == number:
                break
        seconds = time.monotonic() - started_s
    apart_us.sort()
    return {
        "pairs": len(apart_us),
        "refused": refused,
        "seconds": round(seconds, 1),
        "mismatches": sum(apart > apart_max_us + CLOCK_MARGIN_US for apart in apart_us),
        "out_of_order": sum(b[0] <= a[0] or b[1] <= a[1] for a, b in itertools.pairwise(numbers)),
        "apart_median_ms": round(apart_us[len(apart_us) // 2] / 1000, 1),
        "apart_p99_ms": round(apart_us[len(apart_us) * 99 // 100] / 1000, 1),
        "apart_most_ms": round(apart_us[-1] / 1000, 1),
        "load": round(os.getloadavg()[0], 1),
    }


def fired_pairs(number=1000):
    """Cameras that this computer fires, each by its own command: they expose together without a wire."""
    return pairs(number, apart_max_us=8_000, trigger="Software")


def packet_loss():
    """Pictures of which packets are lost: none may be measured, and each must be counted."""
    with both(left_lost=2, right_lost=2), GenicamSource(settings(), PERIOD_US) as source:
        seen = list(pairs_of(source, 200, within_s=60))
    broken = sum(not picture.any(axis=1).all() for pair in seen for picture in (pair.left, pair.right))
    return {"pairs": len(seen), "broken": broken, "dropped": seen[-1].dropped}


def reopened(begin_s, within_s=60.0):
    """Seconds until pairs come again, opening as the station does."""
    while time.monotonic() < begin_s + within_s:
        with contextlib.suppress(CameraError), GenicamSource(settings(), PERIOD_US) as source:
            for _ in pairs_of(source, 1, within_s=8.0):
                return round(time.monotonic() - begin_s, 1)
        time.sleep(RETRY_S)
    return None


def lost(source):
    """The sentence of a camera that is lost, and after how long it was told."""
    begun_s = time.monotonic()
    try:
        for _ in pairs_of(source, 10**6, within_s=LOST_WITHIN_S):
            pass
    except CameraError as error:
        return str(error), error.fault, round(time.monotonic() - begun_s, 1)
    return "", "", None


def killed_and_back():
    with contextlib.ExitStack() as stack:
        left, _ = stack.enter_context(both())
        with GenicamSource(settings(), PERIOD_US) as source:
            list(pairs_of(source, 50))
            left.kill()
            left.wait()
            sentence, fault, after_s = lost(source)
        time.sleep(3)
        with fake_camera(LEFT):
            back_s = reopened(time.monotonic())
    return {"sentence": sentence, "fault": fault, "fault_after_s": after_s, "back_after_s": back_s}


def wrong_pixel_format():
    with both():
        begun_s = time.monotonic()
        try:
            GenicamSource(settings(pixel_format="Mono12"), PERIOD_US).__enter__()
        except CameraError as error:
            told = {"sentence": str(error), "fault": error.fault, "fault_after_s": round(time.monotonic() - begun_s, 1)}
        told["back_after_s"] = reopened(time.monotonic())
    return told


def wrong_packet_size():
    """Packets for jumbo frames, and a network that then carries 1500 bytes only."""
    with both():
        for serial in (LEFT, RIGHT):
            camera = Aravis.Camera.new(next(c.device for c in connected() if c.serial == serial))
            camera.gv_set_packet_size(8000)
            del camera
        with GenicamSource(settings(), PERIOD_US) as source:
            before = len(list(pairs_of(source, 50)))
            sizes = [device._camera.gv_get_packet_size() for device in source._devices]
            subprocess.run(["ip", "link", "set", "lo", "mtu", "1500"], check=True)
            sentence, fault, after_s = lost(source)
        back_s = reopened(time.monotonic())
        with GenicamSource(settings(), PERIOD_US) as source:
            sizes_after = [device._camera.gv_get_packet_size() for device in source._devices]
    return {
        "pairs_before": before, "packet_bytes": sizes, "sentence": sentence, "fault": fault, "fault_after_s": after_s,
        "back_after_s": back_s, "packet_bytes_after": sizes_after,
    }  # fmt: skip


def some_pairs():
    return {"free": pairs(60), "fired": fired_pairs(60)}


FEATURES = {"ActionSelector": 0x4000, "ActionDeviceKey": 0x4004, "ActionGroupKey": 0x4008, "ActionGroupMask": 0x400C}
PTP_REGISTER = 0x4010
INTEGER = """
<Integer Name="{name}"><pValue>{name}Register</pValue></Integer>
<IntReg Name="{name}Register"><Address>{address}</Address><Length>4</Length><AccessMode>RW</AccessMode>
<pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
"""
PTP = """
<Boolean Name="PtpEnable"><pValue>PtpEnableRegister</pValue><OnValue>1</OnValue><OffValue>0</OffValue></Boolean>
<IntReg Name="PtpEnableRegister"><Address>{address}</Address><Length>4</Length><AccessMode>RW</AccessMode>
<pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
"""


def more_features(folder):
    """Description of the fake camera with features in registers that are free: it keeps what is written there."""
    Aravis.enable_interface("Fake")
    camera = Aravis.Camera.new(next(one.device for one in connected() if one.protocol == "Fake"))
    text = camera.get_device().get_genicam_xml()
    text = text if isinstance(text, str) else text[0]
    Aravis.disable_interface("Fake")
    added = "".join(INTEGER.format(name=name, address=hex(place)) for name, place in FEATURES.items())
    added += PTP.format(address=hex(PTP_REGISTER))
    action = '<EnumEntry Name="Action1"><Value>2</Value></EnumEntry>'
    place = text.index("<pValue>TriggerSourceRegister</pValue>")
    text = text[:place] + action + text[place:]
    file = Path(folder) / "camera.xml"
    file.write_text(text.replace("</RegisterDescription>", added + "</RegisterDescription>"))
    return file


def told_features():
    """What stands in the camera's registers, read by a client of its own, once the gauge has opened it."""
    with tempfile.TemporaryDirectory() as folder:
        description = more_features(folder)
        with fake_camera(LEFT, description=description), fake_camera(RIGHT, description=description):
            source = GenicamSource(settings(trigger="Action1", common_clock=True), PERIOD_US)
            with patch.object(device, "FIRST_TIME_S", 1.0), contextlib.suppress(CameraError), source:
                pass  # a fake camera fires at no action command
            asked = Aravis.Camera.new(next(one.device for one in connected() if one.serial == LEFT)).get_device()
            found = {name: asked.read_register(place) for name, place in FEATURES.items()}
            found["PtpEnable"] = asked.read_register(PTP_REGISTER)
    found.pop("ActionSelector")
    return found


def own_clock():
    """What a camera's clock is taken to show, beside the wall clock by which a fake camera stamps."""
    with fake_camera(LEFT), contextlib.closing(Device(LEFT, settings())) as opened:
        before = opened.own_clock_s()
        until_s = time.monotonic() + SETTLED_S
        while time.monotonic() < until_s:
            opened.take(0.1)
        shown_s = opened.own_clock_s()
        return {"before_the_first_picture": before, "ahead_of_the_true_clock_s": shown_s - time.time()}


SCENARIOS = (
    own_clock,
    told_features,
    pairs,
    fired_pairs,
    some_pairs,
    packet_loss,
    killed_and_back,
    wrong_pixel_format,
    wrong_packet_size,
)

if __name__ == "__main__":
    print(json.dumps(next(one for one in SCENARIOS if one.__name__ == sys.argv[1])()))
