"""Two GigE Vision cameras as a pair, in a network of their own: what goes wrong with them, and that it is told.

The study `cameras` does the same for longer.
"""

import json
import struct
import sys

import gige_cameras
import pytest

from appliance.cameras.genicam.device import Device
from appliance.cameras.genicam.trigger import CONTROL_PORT, action_packet

pytestmark = pytest.mark.waiting

PAIRS = 60
CLOCK_WITHIN_S = 0.04  # a period; the fake camera stamps when it begins to send


def test_pairs_that_count_were_exposed_together_whether_they_run_freely_or_are_fired():
    found = gige_cameras.scenario("some_pairs", timeout=60)
    for kind in ("free", "fired"):
        assert found[kind]["pairs"] == PAIRS
        assert found[kind]["mismatches"] == 0
        assert found[kind]["out_of_order"] == 0


def test_what_a_camera_is_told_of_action_commands_clock_and_chunks_arrives_in_its_registers():
    found = gige_cameras.scenario("told_features", timeout=60)
    assert found == {"ActionDeviceKey": 0x486F7467, "ActionGroupKey": 1, "ActionGroupMask": 1, "PtpEnable": 1}


def test_an_action_command_is_the_packet_of_the_standard():
    """Key 0x42, no flags, command 0x0100 (ACTION_CMD), 12 bytes, its number; then both keys and the mask."""
    expected = bytes([0x42, 0, 1, 0, 0, 12, 0x12, 0x34]) + struct.pack(">III", 0x486F7467, 1, 1)
    assert action_packet(0x1234) == expected


def test_a_scheduled_action_command_carries_the_moment_by_the_cameras_clock():
    """Flag 0x80 (scheduled), 20 bytes: the moment in ns, 64 bits, is the last of them (GigE Vision 2.0)."""
    moment_ns = 1_790_000_000_123_456_789
    expected = bytes([0x42, 0x80, 1, 0, 0, 20, 0x12, 0x34]) + struct.pack(">IIIQ", 0x486F7467, 1, 1, moment_ns)
    assert action_packet(0x1234, moment_ns) == expected


def test_the_cameras_clock_is_known_from_its_pictures():
    found = gige_cameras.scenario("own_clock", timeout=60)
    assert found["before_the_first_picture"] is None
    assert found["ahead_of_the_true_clock_s"] == pytest.approx(0.0, abs=CLOCK_WITHIN_S)


LISTENER = """
import json, socket, time
from appliance.cameras.genicam.trigger import ActionCommand, Firing
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
    listener.bind(("", {port}))
    listener.settimeout(5)
    command = ActionCommand(["127.0.0.1", "127.0.0.1"])
    firing = Firing(command.send, 20.0)
    begun = time.monotonic()
    got = [listener.recv(100).hex() for _ in range(10)]
    took = time.monotonic() - begun
    firing.close()
    command.close()
print(json.dumps([got, took]))
"""


def test_action_commands_go_to_all_on_the_network_in_rhythm():
    code = LISTENER.format(port=CONTROL_PORT)
    got, took = json.loads(gige_cameras.in_own_network(sys.executable, "-c", code, timeout=30).splitlines()[-1])
    assert got == [action_packet(number).hex() for number in range(1, 11)]
    assert took == pytest.approx(9 / 20, abs=0.3)


@pytest.mark.parametrize(
    ("ids", "numbers"),
    [
        ([5, 6, 9], [0, 1, 4]),
        ([65534, 65535, 1, 2], [0, 1, 2, 3]),  # a 16-bit block id leaves out 0 (GigE Vision 1.2)
        ([65534, 2], [0, 3]),
        ([70000, 70001, 70003], [0, 1, 3]),  # of 64 bits (GigE Vision 2.0)
        ([7, 9, 8, 10], [0, 2, None, 3]),  # one that a later one overtook
        ([7, 7], [0, None]),
    ],
)
def test_exposures_are_numbered_by_the_cameras_count_and_one_that_was_overtaken_is_left_out(ids, numbers):
    device = object.__new__(Device)
    device._last_id, device._number = None, 0
    assert [device._number if device._count(one) else None for one in ids] == numbers
