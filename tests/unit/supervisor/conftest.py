"""A supervisor with a measuring process that does what it is told, and a connection to it as a PLC has one."""

from collections.abc import Iterator

import pytest
from modbus_wire import Wire
from rehearsal import Rehearsal, rehearsing


@pytest.fixture
def rehearsal(tmp_path, monkeypatch) -> Iterator[Rehearsal]:
    with rehearsing("fake_station", tmp_path, monkeypatch) as rehearsal:
        yield rehearsal


@pytest.fixture
def wire(rehearsal) -> Iterator[Wire]:
    rehearsal.start()
    with rehearsal.connect() as wire:
        yield wire
