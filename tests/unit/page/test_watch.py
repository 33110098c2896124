"""The thread that reads the gauge for the page."""

import threading

from appliance.page import watch as watch_module
from appliance.page.watch import Watch
from plc.poll import Place


def test_a_mistake_while_reading_is_told_and_the_gauge_is_asked_again(monkeypatch):
    asked, again = [], threading.Event()

    def connect(place: Place) -> None:
        asked.append(place)
        if len(asked) > 1:
            again.set()
        raise KeyError("diameter")

    monkeypatch.setattr(watch_module, "connect", connect)
    monkeypatch.setattr(watch_module, "RETRY_PAUSE_S", 0.01)
    watch = Watch(Place("127.0.0.1", 5020))
    watch.start()
    assert again.wait(5)
    watch.stop()
    assert "127.0.0.1:5020: cannot be read (KeyError('diameter'))" in watch.trouble
