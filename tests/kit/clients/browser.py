"""The page in Debian's headless Chromium, and what a person would notice there."""

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, sync_playwright

CHROMIUM = Path("/usr/bin/chromium")
HOTGAUGE = Path(sys.executable).with_name("hotgauge")
SIZES = {"small": (1280, 720), "large": (1920, 1080), "phone": (390, 844)}

CUT = """() => {
  const wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  const found = wide > 1 ? [`the page is ${wide} px too wide`] : [];
  const all = [...document.querySelectorAll("main *, header *")];
  const inner = all.filter((one) => !one.closest(".unseen, .scroll, pre, svg"));
  for (const one of inner) {
    if (one.clientWidth && one.scrollWidth > one.clientWidth + 1 && getComputedStyle(one).display !== "inline")
      found.push(`cut: ${one.tagName} ${one.id} ${one.textContent.trim().slice(0, 40)}`);
  }
  const blocks = [...document.querySelectorAll("main .panel, header > *")];
  const boxes = blocks.map((one) => [one, one.getBoundingClientRect()]);
  for (const [a, first] of boxes) for (const [b, second] of boxes) {
    if (a === b || a.contains(b) || b.contains(a) || !first.width || !second.width) continue;
    const across = Math.min(first.right, second.right) - Math.max(first.left, second.left);
    const down = Math.min(first.bottom, second.bottom) - Math.max(first.top, second.top);
    if (across > 1 && down > 1) found.push(`overlap: ${a.className} ${a.id} and ${b.className} ${b.id}`);
  }
  return found;
}"""


@contextlib.contextmanager
def chromium() -> Iterator[Browser]:
    """Debian's Chromium without a window."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])  # root has no sandbox
        yield browser
        browser.close()


@contextlib.contextmanager
def serving_page(config: Path, log: Path, **environment: str) -> Iterator[subprocess.Popen]:
    """`hotgauge page` as a process, from when it says that it serves to its end."""
    with log.open("ab") as stderr:
        words = [HOTGAUGE, "page", "--config", config]
        process = subprocess.Popen(
            words, stdout=subprocess.PIPE, stderr=stderr, text=True, env=os.environ | environment
        )
    try:
        assert "shows its page on" in process.stdout.readline(), log.read_text()
        yield process
    finally:
        process.terminate()
        process.wait(10)
        process.stdout.close()


def go(page: Page, address: str, within_s: float = 10.0) -> None:
    """Open an address of a server that may still be starting."""
    until_s = time.monotonic() + within_s
    while True:
        try:
            page.goto(address)
        except Exception:
            if time.monotonic() > until_s:
                raise
            time.sleep(0.1)
        else:
            return


def troubles(page: Page) -> list[str]:
    """What is cut, too wide or over something else."""
    return page.evaluate(CUT)


def violations(page: Page) -> list[str]:
    """What axe finds against WCAG 2.1 AA, contrast included."""
    tags = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]
    found = Axe().run(page, options={"runOnly": {"type": "tag", "values": tags}})
    return [f"{one['id']}: {one['nodes'][0]['html'][:120]}" for one in found.response["violations"]]
