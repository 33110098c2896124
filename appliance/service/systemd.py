"""Notifies the service manager and sends the log to the journal. The only importer of systemd-python.

Without the library or without a service manager nothing is notified, and the log goes to standard error.
"""

import contextlib
import faulthandler
import logging
import os
import select
import socket
import sys
from collections.abc import Mapping
from typing import Protocol, cast


class _Daemon(Protocol):
    def notify(self, status: str) -> bool: ...


class _Journal(Protocol):
    def send(self, MESSAGE: str, **fields: object) -> None: ...


try:
    from systemd import daemon, journal  # pyright: ignore[reportMissingImports, reportMissingTypeStubs, reportUnknownVariableType, reportAttributeAccessIssue]
except ImportError:
    _daemon: _Daemon | None = None
    _journal: _Journal | None = None
else:
    _daemon, _journal = cast("_Daemon", daemon), cast("_Journal", journal)

JOURNAL_SOCKET = "/run/systemd/journal/socket"
FIELD_PREFIX = "HOTGAUGE_"
_FORMAT = "%(asctime)s %(levelname)s %(message)s"
_SYSLOG_PRIORITIES = {logging.DEBUG: 7, logging.INFO: 6, logging.WARNING: 4, logging.ERROR: 3, logging.CRITICAL: 2}


def available() -> bool:
    """Whether systemd-python is installed."""
    return _daemon is not None


def is_managed() -> bool:
    """Whether a service manager has started this process and waits for its READY=1."""
    return "NOTIFY_SOCKET" in os.environ


class ServiceManager:
    """The service manager that has started this process, if any; notifying it never waits and never raises."""

    def __init__(self) -> None:
        self._ready = False
        self._status = ""

    def ready(self) -> None:
        """Notify that the port answers."""
        self._ready = _notify("READY=1")

    def proof(self, status: str) -> None:
        """Restart the watchdog's timer: the port has answered with a new heartbeat.

        Parameters
        ----------
        status : str
            State of the gauge in words, for `systemctl status`.
        """
        news = f"\nSTATUS={status}" if status != self._status else ""
        again = "" if self._ready else "\nREADY=1"
        if _notify(f"WATCHDOG=1{news}{again}"):
            self._ready = True
            self._status = status

    def stopping(self) -> None:
        """Notify that the gauge is stopping."""
        _notify("STOPPING=1")


def _notify(state: str) -> bool:
    """Notify the manager and return whether it was notified; a full socket or a missing manager gives False at once."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if _daemon is None or not address:
        return False
    try:
        return _listens(address) and _daemon.notify(state)
    except OSError:
        return False


def _listens(address: str) -> bool:
    """Whether a socket has room for a message now; sending without room would block the whole interpreter."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(f"\0{address[1:]}" if address.startswith("@") else address)
        except OSError:
            return False
        return bool(select.select([], [probe], [], 0)[1])


def start_log() -> None:
    """Send the log to the journal under systemd, else to standard error; native crashes print tracebacks."""
    faulthandler.enable()
    if _journal is not None and "JOURNAL_STREAM" in os.environ:
        logging.basicConfig(level=logging.INFO, handlers=[_JournalHandler(_journal)])
    else:
        handler = _UnblockedHandler()
        handler.setFormatter(logging.Formatter(_FORMAT))
        logging.basicConfig(level=logging.INFO, handlers=[handler])


def write_unblocked(file: int, text: str) -> None:
    """Write a line if there is room for it now, else drop it; raises `OSError` for a full disk or a reader gone.

    Parameters
    ----------
    file : int
        Descriptor. A pipe that is ready has room for `select.PIPE_BUF` bytes (POSIX), so a shorter write never waits.
    text : str
        Without its line end; what is longer is cut.
    """
    if select.select([], [file], [], 0)[1]:
        os.write(file, f"{text}\n".encode()[: select.PIPE_BUF])


class _UnblockedHandler(logging.Handler):
    """Writes records to standard error; a reader that stands still loses records and does not stop the gauge."""

    def emit(self, record: logging.LogRecord) -> None:
        with contextlib.suppress(OSError):
            write_unblocked(sys.stderr.fileno(), self.format(record))


class _JournalHandler(logging.Handler):
    """Sends records to the journal with their fields, so that `journalctl HOTGAUGE_FAULT=103` finds them."""

    def __init__(self, journal: _Journal) -> None:
        super().__init__()
        self._journal = journal

    def emit(self, record: logging.LogRecord) -> None:
        try:
            if _listens(JOURNAL_SOCKET):
                self._journal.send(self.format(record), **fields_of(record))
        except OSError:
            self.handleError(record)


def fields_of(record: logging.LogRecord) -> Mapping[str, object]:
    """Fields of a record's entry in the journal, without its text."""
    own = {name: value for name, value in vars(record).items() if name.startswith(FIELD_PREFIX)}
    return {
        "PRIORITY": _SYSLOG_PRIORITIES.get(record.levelno, 6),
        "SYSLOG_IDENTIFIER": "hotgauge",
        "LOGGER": record.name,
        **own,
    }
