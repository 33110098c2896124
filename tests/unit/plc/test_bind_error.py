"""What a person reads when a port cannot be had."""

import errno
import os
import socket

import pytest

from plc.listener import bind_error


@pytest.mark.parametrize(
    ("error", "host", "sentence"),
    [
        (
            OSError(errno.EADDRINUSE, os.strerror(errno.EADDRINUSE)),
            "127.0.0.1",
            "cannot serve on 127.0.0.1:502: Address already in use; stop what uses it or set plc.port",
        ),
        (
            OSError(errno.EACCES, os.strerror(errno.EACCES)),
            "::1",
            "cannot serve on [::1]:502: Permission denied; ports below 1024 need a right that the installed service has; "
            "set plc.port",
        ),
        (
            OSError(errno.EADDRNOTAVAIL, os.strerror(errno.EADDRNOTAVAIL)),
            "10.9.9.9",
            "cannot serve on 10.9.9.9:502: this computer does not have this address; set plc.host to one that it has, or "
            "to ::",
        ),
        (
            socket.gaierror(socket.EAI_NONAME, "Name or service not known"),
            "gauge",
            "cannot serve on gauge:502: no host of this name is known; set plc.host to an address of this computer",
        ),
        (
            OSError(errno.EMFILE, os.strerror(errno.EMFILE)),
            "127.0.0.1",
            "cannot serve on 127.0.0.1:502: Too many open files; set plc.port",
        ),
    ],
)
def test_the_sentence_says_what_where_and_what_to_do(error, host, sentence):
    assert bind_error(error, host, 502, "plc.port").sentence == sentence
