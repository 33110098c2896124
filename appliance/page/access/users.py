"""The file of those who may log in: name, role, and the password as a hash (Argon2id, RFC 9106)."""

import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from argon2 import PasswordHasher
from argon2.exceptions import Argon2Error, InvalidHashError

from appliance.errors import HotgaugeError
from appliance.files.atomic_file import whole_file
from plc.security.roles import Role

PASSWORD_MIN = 10  # characters; chosen, NIST SP 800-63B asks for 8
PASSWORD_MAX = 256  # characters; longer ones would only cost time
SECRET_MODE = 0o600

_HASHER = PasswordHasher()
_NOBODY = _HASHER.hash("")  # an unknown name takes as long as a wrong password


class UsersError(HotgaugeError):
    """The file of users cannot be read or written, or a user is not possible; the message says what to do."""


class User(NamedTuple):
    """One who may log in."""

    name: str
    role: Role
    password_hash: str


class Users:
    """The users of a file; it is read anew for each log-in, so that a change counts at once.

    Parameters
    ----------
    file : Path
    """

    def __init__(self, file: Path) -> None:
        self.file = file

    def all(self) -> list[User]:
        """Everybody in the file, nobody if there is none; raises `UsersError`."""
        try:
            rows = json.loads(self.file.read_text(encoding="utf-8"))
            return [User(str(row["name"]), Role(row["role"]), str(row["password_hash"])) for row in rows]
        except FileNotFoundError:
            return []
        except OSError as error:
            raise UsersError(f"{self.file}: {error.strerror}; let the page's user read it") from error
        except (ValueError, KeyError, TypeError) as error:
            raise UsersError(f"{self.file}: no file of users; delete it and use hotgauge page-user") from error

    def put(self, name: str, role: Role, password: str) -> None:
        """Add a user, or give one another role and password.

        Parameters
        ----------
        name : str
        role : Role
        password : str

        Raises
        ------
        UsersError
            Name or password are not possible, or the file cannot be written.
        """
        if not name.isprintable() or not 1 <= len(name) <= 60 or name != name.strip():
            raise UsersError(f"user {name!r}: give a name of 1 to 60 characters")
        if not PASSWORD_MIN <= len(password) <= PASSWORD_MAX:
            raise UsersError(f"password: give {PASSWORD_MIN} to {PASSWORD_MAX} characters")
        others = [user for user in self.all() if user.name != name]
        self._write([*others, User(name, role, _HASHER.hash(password))])

    def remove(self, name: str) -> None:
        """Take a user out; raises `UsersError` if there is none of this name."""
        others = [user for user in self.all() if user.name != name]
        if len(others) == len(self.all()):
            raise UsersError(f"user {name!r}: {self.file} has none of this name")
        self._write(others)

    def check(self, name: str, password: str) -> User | None:
        """The user with this name and password, in the same time whether the name or the password is wrong.

        Parameters
        ----------
        name : str
        password : str
        """
        found = next((user for user in self.all() if user.name == name), None)
        try:
            _HASHER.verify(_NOBODY if found is None else found.password_hash, password[:PASSWORD_MAX])
        except (Argon2Error, InvalidHashError):
            return None
        return found

    def _write(self, users: Iterable[User]) -> None:
        rows = [user._asdict() for user in users]
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(self.file, mode=SECRET_MODE) as file:
                json.dump(rows, file, ensure_ascii=False, indent=1)
            folder = self.file.parent.stat()
            if os.geteuid() == 0:  # root writes it for the page's user, whose folder it is in
                os.chown(self.file, folder.st_uid, folder.st_gid)
        except OSError as error:
            raise UsersError(f"{self.file}: {error.strerror}; give a folder that can be written") from error
