"""Installs the gauge as a systemd service on a Debian computer, and removes it."""

import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from appliance.errors import HotgaugeError
from appliance.service import systemd as service

CONFIG = Path("etc/hotgauge/hotgauge.toml")
UNIT = Path("etc/systemd/system/hotgauge.service")
PAGE_UNIT = Path("etc/systemd/system/hotgauge-page.service")
CACHE = Path("var/cache/hotgauge")  # the unit's NUMBA_CACHE_DIR is the folder `numba` in it
USER = "hotgauge"
COMPILE_TIME_S = 300.0  # chosen: half a minute on two cores, far more on a small computer that is busy
STATE = Path("var/lib/hotgauge")
HOME_FOLDERS = (Path("/home"), Path("/root"), Path("/run/user"))


REFUSED_CHARACTERS = frozenset("\\\"'")  # systemd 252: "executable name contains special characters"


class InstallError(HotgaugeError):
    """The service cannot be installed or removed; the message says what, where and what to do."""


class _File(NamedTuple):
    """A file of the folder `systemd`, and its path below the root."""

    source: str
    target: Path


FILES = (
    _File("hotgauge.service", UNIT),
    _File("sysusers.conf", Path("etc/sysusers.d/hotgauge.conf")),
    _File("tmpfiles.conf", Path("etc/tmpfiles.d/hotgauge.conf")),
    _File("udev.rules", Path("etc/udev/rules.d/70-hotgauge.rules")),
    _File("hotgauge-page.service", PAGE_UNIT),
)


def templates() -> Path:
    """The folder `systemd` of the repository, else the one that was installed with the package."""
    beside = Path(__file__).parents[2] / "systemd"
    return beside if beside.is_dir() else Path(sys.prefix) / "share" / "hotgauge" / "systemd"


def install(root: Path) -> Iterator[str]:
    """Write all files, then enable the service and start it, or start it anew; an existing settings file is kept.

    Parameters
    ----------
    root : Path
        `/`; below any other folder only the files are written.

    Yields
    ------
    str
        One line for each step done.

    Raises
    ------
    InstallError
    """
    live = root == Path("/")
    if live:
        _check_computer()
    for file in FILES:
        yield _write(root / file.target, _text(file.source), keep=False)
    yield _write(root / CONFIG, _text("hotgauge.toml"), keep=True)
    if live:
        _run("systemd-sysusers", root / FILES[1].target)
        _run("systemd-tmpfiles", "--create", root / FILES[2].target)
        _reload_udev()
        _run("systemctl", "daemon-reload")
        _run("systemctl", "enable", UNIT.name)
        yield _compile(root / CACHE)  # while the program of before still measures
        _run("systemctl", "restart", "--no-block", UNIT.name)  # one that runs already has the program of before
        yield f"{UNIT.name} is enabled and starts; see it with: systemctl status hotgauge"
        yield _enable_page()


def remove(root: Path) -> Iterator[str]:
    """Stop the service and remove the files of `install`; edited settings and kept set points stay and are named.

    Parameters
    ----------
    root : Path
        As for `install`.

    Yields
    ------
    str

    Raises
    ------
    InstallError
    """
    live = root == Path("/")
    if live:
        _check_root()
        _disable(root)
    for file in FILES:
        yield from _delete(root / file.target)
    if (root / CONFIG).is_file() and (root / CONFIG).read_bytes() == _text("hotgauge.toml").encode():
        yield from _delete(root / CONFIG)
    if (root / CACHE).is_dir():
        shutil.rmtree(root / CACHE)
        yield f"removed {root / CACHE}"
    if live:
        _run("systemctl", "daemon-reload")
        _reload_udev()
    folder = (root / CONFIG).parent
    if folder.is_dir() and not any(folder.iterdir()):
        folder.rmdir()
    for place in (root / CONFIG, root / STATE):
        if place.exists():
            yield f"kept {place}; delete it if it is not wanted"


def _check_computer() -> None:
    _check_root()
    if shutil.which("systemctl") is None:
        raise InstallError("this computer has no systemd; run `hotgauge run` under its own service manager")
    if not service.available():
        raise InstallError(
            "systemd-python is missing, without which the service is never ready; "
            "apt-get install gcc pkg-config libsystemd-dev python3-dev, then pip install systemd-python"
        )
    for place in (Path(sys.executable), Path(sys.base_prefix), templates()):
        if any(place.resolve().is_relative_to(home) for home in HOME_FOLDERS):
            raise InstallError(f"{place}: a service sees no home directories; install hotgauge in a venv in /opt")


def _compile(cache: Path) -> str:
    """Compile what measuring needs as the service's user, so that its first start measures as soon as a later one."""
    cache.mkdir(mode=0o750, parents=True, exist_ok=True)
    shutil.chown(cache, USER, USER)
    command = [sys.executable, "-P", "-m", "appliance.service.compiled_code"]
    environment = {"NUMBA_CACHE_DIR": str(cache / "numba"), "HOME": "/", "PATH": os.defpath}
    try:
        subprocess.run(
            command, check=True, capture_output=True, timeout=COMPILE_TIME_S, cwd="/", env=environment,
            user=USER, group=USER, extra_groups=(), umask=0o077,
        )  # fmt: skip
    except (OSError, subprocess.SubprocessError) as error:
        return f"{cache}: nothing could be compiled ahead ({error}); the first start compiles, for half a minute"
    return f"compiled what measuring needs into {cache}"


def _enable_page() -> str:
    """Enable the page and start it, or start it anew, if its libraries are here."""
    if importlib.util.find_spec("starlette") is None:
        return f"{PAGE_UNIT.name} stays off: for the page in a browser, pip install 'hotgauge[page]' and install again"
    _run("systemctl", "enable", PAGE_UNIT.name)
    _run("systemctl", "restart", "--no-block", PAGE_UNIT.name)
    return f"{PAGE_UNIT.name} is enabled and starts; say who may log in with: hotgauge page-user"


def _disable(root: Path) -> None:
    for unit in (PAGE_UNIT, UNIT):
        if (root / unit).exists():
            _run("systemctl", "disable", "--now", unit.name)


def _check_root() -> None:
    if os.geteuid() != 0:
        raise InstallError("only root can do this; use sudo, or --root DIR to look at the files first")


def _text(source: str) -> str:
    try:
        text = (templates() / source).read_text(encoding="utf-8")
    except OSError as error:
        raise InstallError(f"{templates() / source}: {error.strerror}; install hotgauge again") from error
    return text.replace("@PYTHON@", _quoted(sys.executable))


def _quoted(path: str) -> str:
    """Path as one word of a unit file (systemd.syntax, systemd.service): quoted, without specifiers."""
    if refused := set(path) & REFUSED_CHARACTERS:
        raise InstallError(f"{path}: systemd starts no program with {min(refused)} in its path; use another folder")
    return f'"{path.replace("%", "%%")}"'


def _write(path: Path, text: str, *, keep: bool) -> str:
    if keep and path.exists():
        return f"kept {path}"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InstallError(f"{path}: {error.strerror}; give a folder that can be written") from error
    return f"wrote {path}"


def _delete(path: Path) -> Iterator[str]:
    if path.exists():
        path.unlink()
        yield f"removed {path}"


def _reload_udev() -> None:
    if shutil.which("udevadm") is not None:  # containers lack udev
        subprocess.run(["udevadm", "control", "--reload"], check=False, capture_output=True)


def _run(*words: str | Path) -> None:
    ended = subprocess.run(words, check=False, capture_output=True, text=True)
    if ended.returncode != 0:
        said = ended.stderr.strip().splitlines() or [f"exit code {ended.returncode}"]
        raise InstallError(f"{' '.join(map(str, words))}: {said[-1]}; see `systemctl status hotgauge`")
