"""A copy of the repository to change, and pytest in a process that has loaded the large libraries already."""

import json
import multiprocessing
import os
import resource
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import NamedTuple

import numba
import pytest

ROOT = Path(__file__).parents[2]
NOT_COPIED = shutil.ignore_patterns(".git", ".venv*", ".pytest_cache")
LIBRARIES = ("numpy", "scipy.optimize", "scipy.ndimage", "scipy.stats", "cv2", "numba", "pytest")
MOST_MEMORY_BYTES = 8 << 30
PROCESSES = multiprocessing.get_context("forkserver")
REPORT = "report.json"


class Ending(NamedTuple):
    """How tests ended.

    Attributes
    ----------
    code : int or None
        pytest's exit code; None after the limit.
    failed : str
        The first test that failed, or the file that could not be imported.
    seconds : dict
        Of each test that passed.
    """

    code: int | None
    failed: str = ""
    seconds: Mapping[str, float] = MappingProxyType({})


def copied(folder: Path) -> Path:
    """A copy of the repository, from which this process and its children import from now on."""
    copy = shutil.copytree(ROOT, folder / "copy", ignore=NOT_COPIED)
    sys.path[:] = [str(copy), str(copy / "tests"), *(path for path in sys.path if not _is_ours(path))]
    os.environ |= {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    PROCESSES.set_forkserver_preload(list(LIBRARIES))
    return copy


def _is_ours(path: str) -> bool:
    place = Path(path).resolve()
    return place == ROOT or place.is_relative_to(ROOT / "tests")


def run_tests(
    copy: Path, tests: Iterable[str], limit_s: float, options: tuple[str, ...] = ("-x",), compile_anew: bool = False
) -> Ending:
    """Run tests in the copy; after the limit they and all that they started are killed.

    Parameters
    ----------
    copy : Path
    tests : iterable of str
        Node ids, files or folders.
    limit_s : float
    options : tuple of str
        Of pytest.
    compile_anew : bool
        Leave numba's cache: it does not see that a called function of another file has changed.
    """
    with tempfile.TemporaryDirectory() as folder:
        words = ["-q", "-p", "no:cacheprovider", *options, *tests]
        process = PROCESSES.Process(target=_run, args=(copy, words, Path(folder), compile_anew, limit_s))
        process.start()
        process.join(limit_s)
        code = process.exitcode
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid or 0, signal.SIGKILL)
        process.join()
        report = Path(folder) / REPORT
        return Ending(code, **json.loads(report.read_text(encoding="utf-8") if report.exists() else "{}"))


def _run(copy: Path, words: list[str], folder: Path, compile_anew: bool, limit_s: float) -> None:
    os.setsid()
    os.chdir(copy)
    resource.setrlimit(resource.RLIMIT_CPU, (int(limit_s), int(limit_s)))  # also when nobody waits any more
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY_BYTES, MOST_MEMORY_BYTES))
    sys.modules["__main__"] = ModuleType("__main__")  # what the tests spawn does not load this module again
    silent = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(silent, stream)
    if compile_anew:
        os.environ["NUMBA_CACHE_DIR"] = str(folder)
        numba.config.reload_config()
    os._exit(int(pytest.main(words, plugins=[_Reporter(folder / REPORT)])))


class _Reporter:
    """Writes down which test failed first, and the seconds of those that passed."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.failed = ""
        self.seconds: dict[str, float] = {}
        self.bad = set[str]()

    def pytest_runtest_logreport(self, report) -> None:
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration
        if not report.passed:
            self.bad.add(report.nodeid)
        if report.failed:
            self.failed = self.failed or report.nodeid

    def pytest_collectreport(self, report) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid

    def pytest_sessionfinish(self) -> None:
        seconds = {test: round(spent_s, 3) for test, spent_s in self.seconds.items() if test not in self.bad}
        self.file.write_text(json.dumps({"failed": self.failed, "seconds": seconds}), encoding="utf-8")
