"""Pictures of a folder as a camera sees them: by this computer's clock, in step with every other camera here."""

import threading
from pathlib import Path

import cv2
import numpy as np


class ShownPictures:
    """Grey pictures of a folder, each for `held_s`, again and again; grain keeps any two from being the same."""

    def __init__(self, folder, held_s, log=None):
        self._grain = np.random.default_rng(7)
        self._log = log
        self._lock = threading.Lock()
        self.show(folder, held_s)

    def show(self, folder, held_s):
        paths = sorted(Path(folder).iterdir())
        assert paths, f"{folder}: no pictures to show"
        pictures = [cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in paths]
        with self._lock:
            self._pictures, self._held_s = pictures, held_s

    def at(self, moment_ms):
        """Picture of a moment of the monotonic clock, ms; with a log, its number and moment become a line there."""
        with self._lock:
            number = int(moment_ms / 1000 / self._held_s) % len(self._pictures)
            picture = self._pictures[number]
        if self._log is not None:
            print(number, moment_ms, file=self._log, flush=True)
        grain = self._grain.integers(-2, 3, picture.shape, dtype=np.int16)
        return np.clip(picture + grain, 0, 255).astype(np.uint8)
