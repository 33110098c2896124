"""A disk that hangs until it is let go on."""

import threading

LONGEST_S = 30.0  # who waits for the disk goes on after it, and finds that it hangs no more


class HangingDisk:
    """Holds up whoever writes."""

    def __init__(self):
        self._hangs, self._goes_on, self._ended = threading.Event(), threading.Event(), threading.Event()

    def hang(self, *_):
        """Takes the place of what writes."""
        self._hangs.set()
        self._goes_on.wait(LONGEST_S)
        self._goes_on.set()
        self._ended.set()

    def wait_for_hanging(self):
        assert self._hangs.wait(LONGEST_S)

    @property
    def still_hangs(self):
        return self._hangs.is_set() and not self._ended.is_set()

    def go_on(self):
        self._goes_on.set()
