"""A real systemd in a container whose files are this computer's, seen through a layer that is thrown away."""

import contextlib
import os
import shutil
import subprocess
import sys
import sysconfig
import time
from collections.abc import Iterator
from pathlib import Path

REPOSITORY = Path(__file__).parents[3]
PYTHON = f"python{sys.version_info.major}.{sys.version_info.minor}"
TARGET = """[Unit]
Requires=basic.target systemd-journald.service
After=systemd-journald.service
AllowIsolate=yes
"""


class Container:
    """A booted container; commands run in it as root."""

    def __init__(self, root: Path, leader: int) -> None:
        self.root = root
        self._leader = leader

    def run(self, *words: str, check: bool = True, timeout_s: float = 60) -> str:
        ended = subprocess.run(
            ["nsenter", "--all", "--target", str(self._leader), *words],
            capture_output=True, text=True, check=False, timeout=timeout_s,
        )  # fmt: skip
        assert ended.returncode == 0 or not check, ended
        return ended.stdout

    def shows(self, name: str) -> str:
        """A property of the service."""
        return self.run("systemctl", "show", "hotgauge", "--property", name, "--value").strip()


def why_impossible() -> str:
    """What keeps this computer from booting a container; empty when nothing does."""
    if os.geteuid() != 0:
        return "not root"
    missing = [tool for tool in ("systemd-nspawn", "nsenter", "mount") if shutil.which(tool) is None]
    if missing:
        return f"no {missing[0]}"
    words = ["unshare", "--mount", "mount", "-t", "tmpfs", "none", "/mnt"]
    tried = subprocess.run(words, check=False, capture_output=True)
    return "" if tried.returncode == 0 else "mounting is not permitted"


@contextlib.contextmanager
def container(folder: Path) -> Iterator[Container]:
    """Boot a container with the program in /opt/hotgauge; it shares this computer's network."""
    with contextlib.ExitStack() as stack:
        root = overlay(folder, stack)
        put_program(root)
        (root / "etc/systemd/system/tests.target").write_text(TARGET, encoding="utf-8")
        (root / "etc/machine-id").write_text("0123456789abcdef0123456789abcdef\n", encoding="ascii")
        words = ["systemd-nspawn", "--quiet", f"--directory={root}", "--boot", "--register=no", "--keep-unit"]
        words += ["--machine=hotgauge-tests", "--console=pipe", "--kill-signal=SIGRTMIN+4", "--link-journal=no"]
        words += [f"--bind-ro={sys.base_prefix}:/opt/python", f"--bind-ro={REPOSITORY}:/opt/source"]
        words += [f"--bind-ro={sysconfig.get_path('purelib')}:/opt/site"]
        with (folder / "console").open("w", encoding="utf-8") as console:
            nspawn = subprocess.Popen(
                [*words, "systemd.unit=tests.target"], stdin=subprocess.DEVNULL, stdout=console, stderr=console
            )
        try:
            booted = Container(root, leader_of(nspawn))
            wait_until(lambda: booted.run("systemctl", "is-system-running", check=False).strip() == "running", 60)
            booted.run("ldconfig")
            yield booted
        finally:
            nspawn.terminate()
            try:
                nspawn.wait(20)
            except subprocess.TimeoutExpired:
                nspawn.kill()
                nspawn.wait()


def overlay(folder: Path, stack: contextlib.ExitStack) -> Path:
    root, layer, below = (folder / name for name in ("root", "layer", "below"))
    for place in (root, layer, below):
        place.mkdir()
    mount(stack, "--bind", "/", below)
    mount(stack, "-t", "tmpfs", "none", layer)
    (layer / "upper").mkdir()
    (layer / "work").mkdir()
    options = f"lowerdir={below},upperdir={layer / 'upper'},workdir={layer / 'work'}"
    mount(stack, "-t", "overlay", "-o", options, "overlay", root)
    return root


def mount(stack: contextlib.ExitStack, *words: str | Path) -> None:
    subprocess.run(["mount", *words], check=True)
    stack.callback(subprocess.run, ["umount", "--lazy", str(words[-1])], check=False)


def put_program(root: Path) -> None:
    """A virtual environment in /opt, as an installer would make it, whose packages are this one's."""
    venv = root / "opt/hotgauge"
    packages = venv / "lib" / PYTHON / "site-packages"
    packages.mkdir(parents=True)
    (packages / "hotgauge.pth").write_text("/opt/site\n/opt/source\n", encoding="utf-8")
    (venv / "pyvenv.cfg").write_text("home = /opt/python/bin\n", encoding="utf-8")
    (venv / "bin").mkdir()
    (venv / "bin/python").symlink_to(f"/opt/python/bin/{PYTHON}")
    # where the interpreter was built in somebody's home, the service may not read its library there, and would find
    # the one of Debian's own interpreter
    (root / "etc/ld.so.conf.d/00-python.conf").write_text("/opt/python/lib\n", encoding="ascii")


def leader_of(nspawn: subprocess.Popen) -> int:
    """Process id of the container's first process."""
    children = Path(f"/proc/{nspawn.pid}/task/{nspawn.pid}/children")
    wait_until(lambda: nspawn.poll() is not None or children.read_text().split(), 20)
    assert nspawn.poll() is None, "the container did not start"
    return int(children.read_text().split()[0])


def wait_until(is_so, within_s: float) -> float:
    """Seconds until something is so; fails when it is not in time."""
    begun_s = time.monotonic()
    while time.monotonic() < begun_s + within_s:
        if is_so():
            return time.monotonic() - begun_s
        time.sleep(0.1)
    raise AssertionError(f"not so within {within_s} s")
