"""The page in a browser, before the running appliance on the simulated mill; PAGE_SCREENSHOTS=FOLDER keeps pictures."""

import itertools
import os
import signal
import ssl
import threading
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser import SIZES, chromium, go, serving_page, troubles, violations
from ingot_recording import BOTTOM, EMPTY, TOP, write_recording
from playwright.sync_api import Page, expect
from running import Appliance, free_port, running

from appliance.page.access.users import Users
from plc.poll import PollError, Snapshot, poll
from plc.security.certificates import Authority
from plc.security.roles import Role

pytestmark = pytest.mark.waiting

PASSWORD = "a good password"
SCREENSHOTS = os.environ.get("PAGE_SCREENSHOTS", "")
SETTINGS = """
[plc]
port = {port}
writes = "all"
[sizing]
stale_after_ms = 10000  # a busy computer may be late; lateness has tests of its own
[sizing.liveness]
idle_after_s = 120
[sizing.camera]
kind = "mill"
seed = 5
rate_hz = 4
prepared_frames = 40
[sizing.set_points]
target_mm = 120.0
tolerance_plus_mm = 2.0
tolerance_minus_mm = 2.0
[ingot]
references = "{references}"
[ingot.camera]
kind = "recording"
path = "{recording}"
rate_hz = 12
loop = false
[history]
directory = "history"
[page]
port = {page_port}
users = "users.json"
"""


class Site:
    """The appliance, its page, a browser, and a PLC that remembers every scan."""

    def __init__(self, folder: Path, port: int, page_port: int) -> None:
        self.config = folder / "hotgauge.toml"
        self.environment = {"RUNTIME_DIRECTORY": str(folder)}
        self.port = port
        self.address = f"http://127.0.0.1:{page_port}"
        self.log = folder / "page.log"
        self.scans: list[tuple[float, Snapshot]] = []
        self.over = threading.Event()
        self.appliance: Appliance
        self.pages: dict[Role, Page] = {}

    def scan(self) -> None:
        while not self.over.is_set():
            try:
                for snapshot in poll("127.0.0.1", self.port, every_s=0.05):
                    self.scans.append((time.monotonic(), snapshot))
                    if self.over.is_set():
                        return
            except PollError:
                self.over.wait(0.1)

    def start(self):
        return running("run", "--config", self.config, port=self.port, **self.environment)

    def wait(self, wanted, within_s: float) -> Snapshot:
        until_s = time.monotonic() + within_s
        while time.monotonic() < until_s:
            if self.scans and time.monotonic() - self.scans[-1][0] < 0.5 and wanted(self.scans[-1][1]):
                return self.scans[-1][1]
            time.sleep(0.02)
        raise AssertionError(f"not seen within {within_s} s; last: {self.scans[-1:]}")


@pytest.fixture(scope="module")
def site(recordings, tmp_path_factory) -> Iterator[Site]:
    folder = tmp_path_factory.mktemp("page")
    site = Site(folder, free_port(), free_port())
    references = recordings / "ingot_line"
    recording = write_recording(folder / "line", references, EMPTY, BOTTOM, TOP, EMPTY)
    site.config.write_text(
        SETTINGS.format(
            port=site.port, page_port=site.address.rpartition(":")[2], references=references, recording=recording
        )
    )
    for role in Role:
        Users(folder / "users.json").put(role, role, PASSWORD)
    scanning = threading.Thread(target=site.scan)
    with serving_page(site.config, site.log, **site.environment), site.start() as site.appliance, chromium() as browser:
        scanning.start()
        site.wait(lambda seen: seen.values["validity"] != 0, 120)  # the first start compiles
        for role in Role:
            context = browser.new_context(viewport={"width": 1280, "height": 720}, locale="en")
            page = site.pages[role] = context.new_page()
            page.set_default_timeout(10_000)
            log_in(site.address, page, role)
        yield site
        site.over.set()
        scanning.join()


def log_in(address: str, page, role: Role) -> None:
    go(page, f"{address}/login")
    page.fill("#name", str(role))
    page.fill("#password", PASSWORD)
    page.keyboard.press("Enter")
    page.wait_for_url("**/line")


def test_a_wrong_ingot_is_acknowledged_by_the_operator_by_keyboard_and_not_by_the_viewer(site):
    viewer, operator = site.pages[Role.VIEWER], site.pages[Role.OPERATOR]
    for page in (viewer, operator):
        page.locator("#alarm_wrong_orientation").wait_for()
    site.wait(lambda seen: seen.values["ingot_orientation"] == 0, 20)
    time.sleep(1.2)  # the alarm's off-delay: from here on it waits for a person alone
    assert viewer.locator("#acknowledge").count() == 0
    assert "An operator can acknowledge" in viewer.locator("#alarms").inner_text()
    for _ in range(30):
        operator.keyboard.press("Tab")
        if operator.evaluate("document.activeElement.id") == "acknowledge":
            break
    operator.keyboard.press("Enter")
    site.wait(lambda seen: "alarm_wrong_orientation" not in seen.alarms, 5)
    viewer.locator("#alarm_wrong_orientation").wait_for(state="detached")
    assert "Acknowledged." in operator.locator(".said").inner_text()


def test_what_is_shown_is_what_the_registers_say(site):
    page = site.pages[Role.VIEWER]
    site.wait(lambda seen: seen.values["validity"] != 0, 20)
    go(page, f"{site.address}/registers")
    compared = 0
    for _ in range(10):
        time.sleep(0.3)
        shown = dict(page.evaluate("[...document.querySelectorAll('.words')].map((one) => [one.id, one.innerText])"))
        like = [one for _, one in site.scans if f"{one.words[0]:04X}" == shown["words-sequence"]]
        words = {tuple(" ".join(f"{word:04X}" for word in one.words[start:][:2]) for start in (16, 28)) for one in like}
        assert not like or (shown["words-diameter"], shown["words-trust"]) in words
        compared += bool(like)
    assert compared >= 5


def test_the_line_shows_the_diameter_that_was_just_served(site):
    page = site.pages[Role.VIEWER]
    go(page, f"{site.address}/line")
    site.wait(lambda seen: seen.values["validity"] != 0, 20)
    time.sleep(1)
    shown = page.locator("#diameter").inner_text()
    lately = [one.values["diameter"] for at_s, one in site.scans if time.monotonic() - at_s < 2.5]
    assert shown in {"–" if one is None else f"{one:.2f}" for one in lately}


@pytest.mark.parametrize(("language", "light"), [("en", "day"), ("de", "night")])
def test_every_view_fits_every_size_and_can_be_read(site, language, light):
    page = site.pages[Role.ENGINEER]
    found = []
    go(page, f"{site.address}/set?language={language}&light={light}&back=line")
    for view in ("line", "cameras", "registers", "history", "commission"):
        go(page, f"{site.address}/{view}")
        for name, (width, height) in SIZES.items():
            page.set_viewport_size({"width": width, "height": height})
            found += [f"{view} {name}: {one}" for one in troubles(page)]
            if SCREENSHOTS:
                page.screenshot(path=f"{SCREENSHOTS}/{view}-{language}-{light}-{name}.png", full_page=True)
        found += [f"{view}: {one}" for one in violations(page)]
    assert found == []


def test_pictures_of_the_cameras_are_shown_and_fresh(site):
    page = site.pages[Role.VIEWER]
    go(page, f"{site.address}/cameras")
    assert page.locator("#station-sizing img").count() == 2
    sizes = page.evaluate("[...document.images].map((one) => one.naturalWidth)")
    assert min(sizes) > 300
    first = page.locator("#station-sizing img").first
    expect(first).not_to_have_attribute("src", first.get_attribute("src"), timeout=5000)


def test_the_history_shows_bars_and_gives_them_away(site):
    page = site.pages[Role.VIEWER]
    go(page, f"{site.address}/history")
    deadline_s = time.monotonic() + 20
    while page.locator("td:has-text('120')").count() == 0 and time.monotonic() < deadline_s:
        time.sleep(1)
        page.reload()
    with page.expect_download() as got:
        page.click("text=bars.csv")
    text = Path(got.value.path()).read_text()
    assert "diameter" not in text.splitlines()[0]
    assert "mean_mm" in text.splitlines()[0]
    assert len(text.splitlines()) >= 2
    page.locator("tbody a").first.click()
    assert page.locator("#profile svg").count() == 1


def test_the_gauge_does_not_notice_a_page_that_is_killed_and_a_page_says_that_it_is_lost(site):
    page = site.pages[Role.VIEWER]
    go(page, f"{site.address}/line")
    before, station = site.wait(lambda _: True, 5), site.appliance.station("sizing")
    site.scans[:-1] = []
    port = free_port()
    config = site.config.with_name("second.toml")
    config.write_text(site.config.read_text().replace(site.address.rpartition(":")[2], str(port)))
    with serving_page(config, site.log, **site.environment) as process:
        other = page.context.browser.new_context(locale="en").new_page()
        log_in(f"http://127.0.0.1:{port}", other, Role.VIEWER)
        process.send_signal(signal.SIGKILL)
        other.locator("p.lost:not([hidden])").wait_for(timeout=5000)
        assert not other.locator("#diameter").is_visible()
        other.close()
    after = site.wait(lambda _: True, 5)
    assert after.values["clients_refused"] == before.values["clients_refused"]
    assert site.appliance.station("sizing") == station
    gone = [late_s - early_s for (early_s, _), (late_s, _) in itertools.pairwise(site.scans)]
    assert max(gone) < 1.0, "the PLC was answered late"


def test_a_killed_station_shows_within_two_seconds(site):
    page = site.pages[Role.VIEWER]
    go(page, f"{site.address}/line")
    site.wait(lambda seen: seen.values["validity"] != 0, 20)
    expect(page.locator("#diameter")).not_to_have_text("–", timeout=10_000)
    os.kill(site.appliance.station("sizing"), signal.SIGKILL)
    expect(page.locator("#diameter")).to_have_text("–", timeout=2000)
    expect(page.locator("#alarm_internal")).to_be_visible(timeout=2000)


def test_a_calibration_is_made_from_board_pictures_through_the_page(site, recordings):
    """From the pictures of `line_a` to a candidate: the gauge's own rig stays as it is until it is confirmed."""
    place = site.config.parent / "commissioning" / "line_a"
    place.mkdir(parents=True)
    for part in ("calibration", "registration", "board.json"):
        (place / part).symlink_to(recordings / "line_a" / part)
    page = site.pages[Role.ENGINEER]
    go(page, f"{site.address}/commission")
    page.click("#calibrate")
    expect(page.locator("#calibrated .decision")).to_be_visible(timeout=60_000)
    assert "✓" in page.locator("#calibrated .decision").inner_text()
    page.click("#calibrated summary")
    report = page.locator("#calibrated pre").inner_text()
    assert float(report.split("residual      ")[1].split()[0]) < 0.2
    assert page.locator("#verify").is_enabled()
    assert page.locator("#confirm").is_disabled()


def test_board_pictures_are_judged_live_in_the_page_and_stopped(site):
    """On the simulated mill there is no board before the cameras, and so that is what is said until it is stopped."""
    page = site.pages[Role.ENGINEER]
    go(page, f"{site.address}/set?language=en&light=day&back=commission")
    if not page.locator("#take_boards").is_visible():
        page.click("#take_here")
    page.fill("details:has(#take_here) input[name=folder]", "monday")
    page.click("#take_boards")
    expect(page.locator("#capture pre")).to_contain_text("0 of 15 poses; left: no", timeout=20_000)
    if SCREENSHOTS:
        page.screenshot(path=f"{SCREENSHOTS}/commission-capture.png", full_page=True)
    assert not violations(page)
    page.click("#stop")
    expect(page.locator("#capture")).to_contain_text("Go on with monday", timeout=10_000)
    expect(page.locator("#capture pre")).to_contain_text("missing: 15 poses")
    expect(page.locator("#link")).to_contain_text("123.456", timeout=10_000)


def test_the_page_outlives_the_gauge_and_shows_it_again(site):
    """The last test of the site: afterwards no gauge runs there."""
    page = site.pages[Role.VIEWER]
    go(page, f"{site.address}/line")
    site.appliance.process.terminate()
    site.appliance.process.wait(10)
    expect(page.locator("#trouble")).to_be_visible(timeout=5000)
    expect(page.locator("#diameter")).to_have_text("–")
    with site.start():
        expect(page.locator("#trouble")).to_be_hidden(timeout=30_000)


def test_by_tls_the_page_shows_its_certificate_and_binds_the_browser_to_it(tmp_path):
    authority = Authority.make()
    authority.save(tmp_path)
    authority.server(tmp_path, ["127.0.0.1"])
    config, port = tmp_path / "hotgauge.toml", free_port()
    config.write_text(f'[page]\nport = {port}\nusers = "users.json"\ncertificate = "server.pem"\nkey = "server.key"\n')
    trusting = ssl.create_default_context(cafile=tmp_path / "authority.pem")
    with serving_page(config, tmp_path / "log", RUNTIME_DIRECTORY=str(tmp_path)):
        until_s = time.monotonic() + 10
        while True:
            try:
                answer = urllib.request.urlopen(f"https://127.0.0.1:{port}/login", context=trusting)
            except OSError:
                assert time.monotonic() < until_s
                time.sleep(0.1)
            else:
                break
        with answer:
            assert "max-age" in answer.headers["strict-transport-security"]
            assert b"Nobody can log in yet" in answer.read()
        with pytest.raises(OSError, match="CERTIFICATE_VERIFY_FAILED"):
            urllib.request.urlopen(f"https://127.0.0.1:{port}/login", context=ssl.create_default_context())
