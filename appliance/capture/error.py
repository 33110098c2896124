"""The error of taking pictures."""

from appliance.errors import HotgaugeError


class CaptureError(HotgaugeError):
    """Pictures cannot be taken or kept; the message says what, where and what to do."""
