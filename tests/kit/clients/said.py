"""The real program, and every line that it writes."""

import os
import re
import signal
import subprocess
import threading
import time

from running import HOTGAUGE, Appliance


def said_by(*words):
    ended = subprocess.run([HOTGAUGE, *words], capture_output=True, text=True, timeout=90, check=False)
    return ended.returncode, ended.stdout + ended.stderr


class Running:
    """`hotgauge run`, and every line that it has written."""

    def __init__(self, config, port, **environment):
        self.process = subprocess.Popen(
            [HOTGAUGE, "run", "--config", config], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env=os.environ | {"PYTHONFAULTHANDLER": "1"} | environment,
        )  # fmt: skip
        self.appliance = Appliance(self.process, port)
        self.lines = []
        self.listener = threading.Thread(target=self._listen, daemon=True)
        self.listener.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait(10)
        self.listener.join(10)
        self.process.stdout.close()

    def _listen(self):
        self.lines.extend(iter(self.process.stdout.readline, ""))

    def said_within(self, pattern, seconds):
        until_s = time.monotonic() + seconds
        while time.monotonic() < until_s:
            if any(re.search(pattern, line) for line in self.lines):
                return True
            time.sleep(0.05)
        return False

    def take_lines(self):
        lines, self.lines[:] = list(self.lines), []
        return lines

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(20)
