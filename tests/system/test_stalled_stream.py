"""A network that stalls while the bar leaves: the gauge must not serve, as fresh, a bar that is gone."""

import contextlib
import time

from network_cameras import line_to, rtsp_camera
from running import free_port, running
from second_by_second import Polling
from shown_bars import write_bars, write_rig

DIAMETER_MM = 120.0
STALL_S = 2.0
LEAVES_AFTER_S = 0.4
SLACK_S = 0.2  # of the server's own coding on a busy computer
OVER_WITHIN_S = 8.0


def test_a_bar_that_left_during_a_stall_is_never_served_as_younger_than_it_is(tmp_path):
    write_bars(tmp_path / "bar", [DIAMETER_MM])
    write_bars(tmp_path / "empty", [None])
    write_rig(tmp_path / "rig.json")
    port = free_port()
    with contextlib.ExitStack() as stack:
        cameras, lines = [], []
        for side in ("left", "right"):
            show = (tmp_path / "bar" / side, 1)
            cameras.append(stack.enter_context(rtsp_camera(size="800x600", rate=10, show=show)))
            lines.append(stack.enter_context(line_to(cameras[-1].port)))
        left, right = (f"rtsp://127.0.0.1:{line.port}/stream" for line in lines)
        config = tmp_path / "gauge.toml"
        config.write_text(
            f'[plc]\nport = {port}\n[sizing]\nrig = "rig.json"\n[sizing.liveness]\napart_max_us = 50000\n'
            f'[sizing.camera]\nkind = "stream"\nleft = "{left}"\nright = "{right}"\ndelay_ms = 0\n'
        )
        gauge = stack.enter_context(running("run", "--config", config, port=port))
        plc = stack.enter_context(Polling(stack.enter_context(gauge.wire())))
        first = plc.first(time.monotonic(), lambda seen: seen.diameter_mm is not None, 60)
        assert abs(first.diameter_mm - DIAMETER_MM) < 1.0
        time.sleep(2)
        for line in lines:
            line.flows.clear()
        stalled_s = time.monotonic()
        time.sleep(LEAVES_AFTER_S)
        for camera, side in zip(cameras, ("left", "right"), strict=True):
            camera.tell(f"show {tmp_path / 'empty' / side} 1")
        left_s = time.monotonic()
        time.sleep(STALL_S - LEAVES_AFTER_S)
        for line in lines:
            line.flows.set()
        time.sleep(OVER_WITHIN_S)
        served = [seen for seen in plc.since(stalled_s) if seen.diameter_mm is not None]
        late = [seen for seen in served if seen.at_s - seen.age_ms / 1000 > left_s + SLACK_S]
        assert not late, f"exposed after the bar had left: {late[0]}{plc.told(stalled_s)}"
        last = plc.since(stalled_s)[-1]
        assert last.validity == 0, plc.told(stalled_s)
