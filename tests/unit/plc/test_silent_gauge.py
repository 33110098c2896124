"""The miniature PLC before a gauge that takes requests and answers none."""

import contextlib
import socket
import threading

import pytest

from plc import client as client_module
from plc.client import Plc


def test_a_request_without_an_answer_is_not_sent_again_and_the_scan_is_empty(monkeypatch):
    monkeypatch.setattr(client_module, "ANSWER_WITHIN_S", 0.2)
    received: list[bytes] = []
    with socket.create_server(("127.0.0.1", 0)) as silent:

        def take() -> None:
            with contextlib.suppress(OSError):
                connection, _ = silent.accept()
                with connection:
                    while data := connection.recv(4096):
                        received.append(data)

        taker = threading.Thread(target=take, daemon=True)
        taker.start()
        with Plc("127.0.0.1", silent.getsockname()[1]) as plc:
            assert plc.scan() is None
        taker.join(5)
    assert len(received) == 1


@pytest.mark.parametrize("within_s", [0.3])
def test_a_gauge_that_never_answers_is_a_time_out_with_its_place(within_s):
    with Plc("127.0.0.1", 1) as plc, pytest.raises(TimeoutError, match=r"127\.0\.0\.1:1: not seen within 0\.3 s"):
        plc.run(lambda _: True, within_s)
