"""Draws the simulated line's pairs ahead of time, in a process of its own, into a ring of shared memory.

Run as `python -m appliance.mill.renderer LINK RING SLOTS SEED`: the descriptors of a connected socket and of shared
memory with room for that many pairs. Each line received, `SLOT FRAME`, frees a slot and names the earliest frame
that is still wanted; each line sent, as JSON, names a slot that holds a pair, its frame, truth and range. The end of
the link ends the process, so it never outlives the one that asked for it.
"""

import json
import mmap
import selectors
import socket
import sys

import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars.bars import bar_at, truth
from appliance.simulation.bars.laser import MILL_DIRECTION, MILL_ORIGIN_MM, Laser
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.sensor import Sensor
from appliance.simulation.true_rig import default_rig

LASER_STREAM = 0x6C61  # of random numbers, beside those of the pictures


def slots_of(ring: int, slots: int, image_size: tuple[int, int]) -> NDArray[np.uint8]:
    """The ring in shared memory: ndarray of uint8, shape (slots, 2, rows, columns, 3), left picture first."""
    columns, rows = image_size
    shape = (slots, 2, rows, columns, 3)
    return np.frombuffer(mmap.mmap(ring, int(np.prod(shape))), np.uint8).reshape(shape)


def main() -> None:
    """Draw pairs into free slots until the link ends."""
    link_number, ring_number, slots, seed = (int(word) for word in sys.argv[1:])
    link = socket.socket(fileno=link_number)
    rig = default_rig()
    ring = slots_of(ring_number, slots, rig.left.image_size)
    scene = Scene(rig, seed, Sensor())
    laser = Laser(MILL_ORIGIN_MM, MILL_DIRECTION)
    orders = _Orders(link)
    frame = 0
    while (slot := orders.next_slot()) is not None:
        frame = max(frame, orders.wanted)
        bar = bar_at(seed, frame)
        ring[slot] = scene.pair(bar, frame)
        range_mm = laser.range_mm(bar, np.random.default_rng([seed, frame, LASER_STREAM]))
        drawn = {"slot": slot, "frame": frame, "truth": truth(bar), "range_mm": range_mm}
        try:
            link.sendall(json.dumps(drawn).encode() + b"\n")
        except OSError:
            return
        frame += 1


class _Orders:
    """Free slots in the order in which they came, and the earliest frame that is still wanted."""

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._ready = selectors.DefaultSelector()
        self._ready.register(link, selectors.EVENT_READ)
        self._rest = b""
        self._slots: list[int] = []
        self.wanted = 0

    def next_slot(self) -> int | None:
        """A free slot, waited for; None when no more orders can come."""
        # all that has come is read first: when drawing is slow, the newest order says what is still wanted
        while not self._slots or self._ready.select(timeout=0):
            try:
                received = self._link.recv(1 << 16)
            except ConnectionError:
                return None
            if not received:
                return None
            *lines, self._rest = (self._rest + received).split(b"\n")
            for line in lines:
                slot, wanted = (int(word) for word in line.split())
                self._slots.append(slot)
                self.wanted = max(self.wanted, wanted)
        return self._slots.pop(0)


if __name__ == "__main__":
    main()
