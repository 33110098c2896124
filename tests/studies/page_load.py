"""What three people with the page open cost the gauge: PLC answers and measuring rate, with and without them.

The three are HTTP clients with the period of the page's script, each with the live parts of line, cameras and registers
and every new picture: what a browser asks of the page. Their browsers run on other computers and are no load here. The
page runs at low priority, as its unit has it. Cases alternate, so that a drift of the computer's speed counts for both.
"""

import contextlib
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import httpx2
from running import HOTGAUGE, free_port, running

from appliance.page.access.users import Users
from plc.security.roles import Role
from studies.modbus_load import Load, percentiles

TEXT = (
    "Answers to 16 PLC clients that ask for the whole block every 10 ms, times from request to answer, and readings of "
    "the simulated mill per second; 30 s each, in turn without the page and with the page open three times (HTTP "
    "clients that ask as the browser's script does, every 0.5 s; all on one computer). `change_percent`: median of the "
    "three cases with people over that of the three without."
)
REPEATABLE = False  # times are those of the computer
CHUNK = 6  # one process, one case after the other
SECONDS = 30.0
RENEWAL_S = 0.5  # of static/page.js
PASSWORD = "a good password"
VIEWS = ("line", "cameras", "registers")
SETTINGS = """
[plc]
port = {port}
[sizing.camera]
kind = "mill"
rate_hz = 60
[page]
port = {page_port}
users = "users.json"
"""


def cases():
    return [{"turn": turn, "people": people} for turn in range(3) for people in (0, len(VIEWS))]


def run(case, seconds=SECONDS):
    port, page_port = free_port(), free_port()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "hotgauge.toml").write_text(SETTINGS.format(port=port, page_port=page_port))
        Users(folder / "users.json").put("anna", Role.VIEWER, PASSWORD)
        words = ["--config", folder / "hotgauge.toml"]
        with (
            running("run", *words, port=port, RUNTIME_DIRECTORY=name),
            page(words, name) if case["people"] else contextlib.nullcontext(),
            browsers(f"http://127.0.0.1:{page_port}", case["people"]) as answered,
        ):
            load = Load(port, 16)
            wait_for_readings(load)
            load.blocks.clear()
            answered.clear()
            waits_s = load.ask_every(0.01, seconds)
            pages = len(answered)
            load.close()
    readings = {words[:2] for words in load.blocks}
    rates = {"readings_per_s": round(len(readings) / seconds, 1), "pages_per_s": round(pages / seconds, 1)}
    return percentiles(waits_s) | rates


def summary(rows):
    def median(people, name):
        return sorted(row[name] for row in rows if row["people"] == people)[1]

    names = ("p50_ms", "p99_ms", "readings_per_s")
    return {
        name: {
            "without": median(0, name),
            "with_three": median(len(VIEWS), name),
            "change_percent": round(100 * (median(len(VIEWS), name) / median(0, name) - 1), 1),
        }
        for name in names
    }


@contextlib.contextmanager
def page(words, runtime):
    """The page at the priority of its unit."""
    process = subprocess.Popen(
        ["nice", "-n", "10", HOTGAUGE, "page", *words],
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"RUNTIME_DIRECTORY": runtime},
    )
    try:
        assert "shows its page on" in process.stdout.readline()
        yield
    finally:
        process.terminate()
        process.wait(10)
        process.stdout.close()


@contextlib.contextmanager
def browsers(address, count):
    """People who look, each in a process of its own; a line for each answer that any of them had."""
    answered = []
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    words = [sys.executable, "-m", "studies.page_load", address]
    looking = [
        subprocess.Popen([*words, view], stdout=subprocess.PIPE, text=True, env=environment) for view in VIEWS[:count]
    ]
    for one in looking:
        threading.Thread(target=lambda one=one: answered.extend(one.stdout), daemon=True).start()
    try:
        yield answered
    finally:
        for one in looking:
            one.terminate()
            one.wait(10)
            one.stdout.close()


def wait_for_readings(load, within_s=120.0):
    """Until the mill is measured: more than one reading within a second."""
    until_s = time.monotonic() + within_s
    while time.monotonic() < until_s:
        load.blocks.clear()
        load.ask_every(0.1, 1.0)
        if len({words[:2] for words in load.blocks}) > 5:
            return
    raise AssertionError("nothing is measured")


def look(address, view):
    """Log in and renew a view as the page's script does, with the pictures that are new to it."""
    browser = httpx2.Client(base_url=address, headers={"Origin": address})
    browser.post("/login", data={"name": "anna", "password": PASSWORD})
    seen = set()
    while True:
        begun_s = time.monotonic()
        answer = browser.get(f"/live/{view}").raise_for_status()
        for picture in {part.split('"')[0] for part in answer.text.split('src="')[1:]} - seen:
            browser.get(picture).raise_for_status()
            seen.add(picture)
        print(view, flush=True)
        time.sleep(max(0.0, begun_s + RENEWAL_S - time.monotonic()))


if __name__ == "__main__":
    look(*sys.argv[1:])
