"""Takes out of a text what an address may carry and nobody should read."""

import re

HIDDEN = "***"
_USER = re.compile(r"://[^\s]*@")  # up to the last @, because passwords hold some
_QUERY = re.compile(r"(://[^\s?\"']*)\?[^\s\"']*")


def mask(text: str) -> str:
    """Text whose addresses show neither user and password nor their query.

    >>> mask("rtsp://user:a@b#c@10.0.0.11/live is gone")
    'rtsp://***@10.0.0.11/live is gone'
    >>> mask("http://10.0.0.11/video?pwd=secret")
    'http://10.0.0.11/video?***'
    """
    return _QUERY.sub(rf"\1?{HIDDEN}", _USER.sub(f"://{HIDDEN}@", text))
