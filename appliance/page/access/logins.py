"""Log-ins: who they are, and when they end. They live in memory; a restart of the page ends them all."""

import hashlib
import secrets
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from plc.security.roles import Role

LOGINS_MAX = 200  # chosen; the one that was idle longest gives way

_ORDER = list(Role)  # each may do what those before it may


@dataclass(slots=True)
class Login:
    """One log-in of a person.

    Attributes
    ----------
    name : str
    role : Role
    begun_s, acted_s : float
        Monotonic time of the log-in, and of the last click.
    token : str
        What every form must send, so that no other site can send one.
    said : str
        Key of a text to be shown once, in the next page.
    """

    name: str
    role: Role
    begun_s: float
    acted_s: float
    token: str = field(default_factory=lambda: secrets.token_urlsafe(32))
    said: str = ""

    def may(self, role: Role) -> bool:
        """Whether it may do what needs this role."""
        return _ORDER.index(self.role) >= _ORDER.index(role)


class Logins:
    """All log-ins, found by what the browser keeps.

    Parameters
    ----------
    login_max_h : float
        Every log-in ends after it.
    idle_max_min : float
        That of an operator or engineer ends after it without a click.
    clock : callable
        Monotonic time, seconds.
    """

    def __init__(self, login_max_h: float, idle_max_min: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._login_max_s = 3600 * login_max_h
        self._idle_max_s = 60 * idle_max_min
        self._clock = clock
        self._logins: dict[bytes, Login] = {}
        self._one_at_a_time = threading.Lock()

    def begin(self, name: str, role: Role) -> str:
        """Begin a log-in: the secret that its browser keeps, always a new one.

        Parameters
        ----------
        name : str
        role : Role
        """
        now_s = self._clock()
        secret = secrets.token_urlsafe(32)
        with self._one_at_a_time:
            if len(self._logins) >= LOGINS_MAX:
                del self._logins[min(self._logins, key=lambda key: self._logins[key].acted_s)]
            self._logins[_key(secret)] = Login(name, role, now_s, now_s)
        return secret

    def find(self, secret: str, *, acts: bool) -> Login | None:
        """The log-in of a secret, None if there is none or it has ended.

        Parameters
        ----------
        secret : str
        acts : bool
            Whether a person has clicked; a view that renews itself is no sign of one.
        """
        login = self._logins.get(_key(secret))
        if login is None:
            return None
        now_s = self._clock()
        idle = login.role is not Role.VIEWER and now_s - login.acted_s > self._idle_max_s
        if idle or now_s - login.begun_s > self._login_max_s:
            self.end(secret)
            return None
        if acts:
            login.acted_s = now_s
        return login

    def end(self, secret: str) -> None:
        """End a log-in, if there is one."""
        with self._one_at_a_time:
            self._logins.pop(_key(secret), None)


def _key(secret: str) -> bytes:
    """What is kept in memory; nobody logs in with it, and looking it up takes no time that tells of it."""
    return hashlib.sha256(secret.encode()).digest()
