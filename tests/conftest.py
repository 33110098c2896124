"""What all tests share: the recordings, and no skipping behind CI's back."""

import os
import signal
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[1]

LISTED_SKIPS = frozenset(
    {
        "tests/system/test_real_systemd.py",  # a container cannot be booted everywhere
        "tests/system/modbus/test_tmodbus.py",  # tModbus needs Python 3.12
    }
)


def pytest_configure() -> None:
    """Let programs that the tests start hear SIGINT, which a shell's background jobs ignore, and their children too."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def recordings() -> Path:
    folder = Path(os.environ.get("HOTGAUGE_RECORDINGS", REPOSITORY.parent / "shared" / "recordings"))
    if not folder.is_dir():
        pytest.fail(f"{folder}: no recordings there; set HOTGAUGE_RECORDINGS to the folder that holds line_a")
    return folder


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    return report if hasattr(report, "wasxfail") else failed_if_unlisted(report)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    return failed_if_unlisted((yield))


def failed_if_unlisted(report):
    """In CI, a test or a whole file that was skipped and stands in no list has failed."""
    listed = report.nodeid.partition("::")[0] in LISTED_SKIPS
    if report.skipped and not listed and os.environ.get("CI") == "true":
        report.outcome = "failed"
        report.longrepr = f"{report.nodeid} was skipped and is not listed in tests/conftest.py"
    return report
