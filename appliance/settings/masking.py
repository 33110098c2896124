"""Takes out of a text what an address may carry and nobody should read."""

import re

HIDDEN = "***"
_ADDRESS = re.compile(r"://([^\s\"']*)")


def mask(text: str) -> str:
    """Text whose addresses show neither user and password nor their query.

    >>> mask("rtsp://user:a@b#c@10.0.0.11/live is gone")
    'rtsp://***@10.0.0.11/live is gone'
    >>> mask("http://10.0.0.11/video?pwd=secret")
    'http://10.0.0.11/video?***'
    """
    return _ADDRESS.sub(_hidden, text)


def _hidden(address: re.Match[str]) -> str:
    before, at, place = address[1].rpartition("@")
    if "?" in before:  # a query with an @, or a password with a question mark
        return f"://{HIDDEN}"
    place, question_mark, _ = place.partition("?")
    user = HIDDEN + at if at else ""
    return f"://{user}{place}{question_mark}{HIDDEN if question_mark else ''}"
