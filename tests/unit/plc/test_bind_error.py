"""What a person reads when a port cannot be had."""

import errno
import os
import socket

import pytest

from plc.listener import bind_error


def of_system(number: int) -> OSError:
    return OSError(number, os.strerror(number))


CASES = {
    errno.EADDRINUSE: ("127.0.0.1", "127.0.0.1:502: Address already in use; stop what uses it or set plc.port"),
    errno.EACCES: (
        "::1",
        "[::1]:502: Permission denied; ports below 1024 need a right that the installed service has;",
    ),
    errno.EADDRNOTAVAIL: ("10.9.9.9", "10.9.9.9:502: this computer does not have this address; set plc.host to one"),
    errno.EMFILE: ("127.0.0.1", "127.0.0.1:502: Too many open files; set plc.port"),
}


@pytest.mark.parametrize("number", CASES)
def test_the_sentence_says_what_where_and_what_to_do(number):
    host, sentence = CASES[number]
    assert bind_error(of_system(number), host, 502, "plc.port").sentence.startswith(f"cannot serve on {sentence}")


def test_a_name_that_nobody_knows_is_no_matter_of_the_port():
    unknown = socket.gaierror(socket.EAI_NONAME, "Name or service not known")
    sentence = bind_error(unknown, "gauge", 502, "plc.port").sentence
    assert sentence.endswith("no host of this name is known; set plc.host to an address of this computer")
