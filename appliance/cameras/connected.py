"""Lists every camera that is connected, of each kind that can be searched for."""

from collections.abc import Callable, Iterator
from pathlib import Path

from appliance.cameras.source import CameraError

VIDEO_DEVICES = Path("/sys/class/video4linux")


def connected_cameras() -> Iterator[str]:
    """One line for each camera, and one for each kind that has none or cannot be searched for."""
    for kind, search in SEARCHES.items():
        try:
            found = list(search())
        except CameraError as error:
            found = [f"cannot be searched for: {error}"]
        for line in found or ["none"]:
            yield f"{kind:<8} {line}"


def _genicam() -> Iterator[str]:
    from appliance.cameras.genicam.settings import aravis

    with aravis():
        from appliance.cameras.genicam.device import connected, described
    for camera in connected():
        yield described(camera)


def _oak() -> Iterator[str]:
    from appliance.cameras.oak.settings import depthai

    with depthai():
        from appliance.cameras.oak.source import connected
    yield from connected()


def _stream() -> Iterator[str]:
    for device in sorted(VIDEO_DEVICES.glob("video*")):
        name = (device / "name").read_text(encoding="utf-8").strip()
        yield f"/dev/{device.name}: {name}"
    yield "network streams cannot be searched for; their address stands in the camera's manual"


SEARCHES: dict[str, Callable[[], Iterator[str]]] = {"genicam": _genicam, "oak": _oak, "stream": _stream}
