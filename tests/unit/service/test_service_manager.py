"""What is said to the service manager, word by word; `tests/system/test_service.py` hears it on a real socket."""

import pytest

from appliance.service import systemd


@pytest.mark.parametrize("heard", [True, False])
def test_ready_is_said_again_until_it_was_heard_and_then_no_more(monkeypatch, heard):
    said = []
    answers = iter([heard])
    monkeypatch.setattr(systemd, "_notify", lambda words: said.append(words) or next(answers, True))
    manager = systemd.ServiceManager()
    manager.ready()
    for status in ("measuring", "measuring", "starting"):
        manager.proof(status)
    again = "" if heard else "\nREADY=1"
    assert said == [
        "READY=1",
        f"WATCHDOG=1\nSTATUS=measuring{again}",
        "WATCHDOG=1",
        "WATCHDOG=1\nSTATUS=starting",
    ]
