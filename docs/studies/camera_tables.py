"""Tables of what cameras over a network do, by the name in the line `<!-- table: NAME -->` that stands before each."""

from collections.abc import Callable

from results import Rows, result, summary

KINDS = {
    "gige": "GigE Vision, fired by this computer",
    "http_mjpeg": "HTTP, JPEG",
    "rtsp_mjpeg": "RTSP, JPEG",
    "rtsp_h264_tcp": "RTSP, H.264, TCP",
    "rtsp_h264_udp": "RTSP, H.264, UDP",
}
LOST = {
    "killed_and_back": "a camera killed, and started again",
    "wrong_pixel_format": "a pixel format that the camera has not",
    "wrong_packet_size": "packets of 8000 bytes in a network that carries 1500",
}


def camera_latency() -> Rows:
    """From exposure to register, ms."""
    found = {row["kind"]: row for row in result("camera_latency")["rows"]}
    names = ("p50_ms", "p99_ms", "p50_stated_ms", "p99_stated_ms")
    head = ("camera", "median", "99 %", "median by `timestamp`", "99 % by `timestamp`")
    return [head, *((title, *(str(found[kind][name]) for name in names)) for kind, title in KINDS.items())]


def two_cameras() -> Rows:
    """What happened to two fake GigE cameras."""
    found = summary("cameras")
    lost = found["packet_loss"]
    pairs = (("pairs", "running freely"), ("fired_pairs", "fired by this computer"))
    return [
        ("what", "fault after", "pictures again after"),
        *(
            (f"{found[name]['pairs']} pairs {how}: {found[name]['mismatches']} mismatched", "none", "-")
            for name, how in pairs
        ),
        (
            f"2 of 1,000 packets lost: {lost['broken']} broken pictures in {lost['pairs']} pairs",
            f"none; {lost['dropped']} pictures dropped and counted",
            "-",
        ),
        *(
            (title, f"{found[name]['fault_after_s']:.0f} s", f"{found[name]['back_after_s']:.0f} s")
            for name, title in LOST.items()
        ),
    ]


CAMERA_TABLES: dict[str, Callable[[], Rows]] = {"camera latency": camera_latency, "two cameras": two_cameras}
