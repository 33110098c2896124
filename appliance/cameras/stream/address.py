"""Address of a stream, and the user and password that go with it but are never shown."""

import os
import stat
from pathlib import Path
from urllib.parse import quote

from appliance.cameras.source import CameraError

FOLDER_VARIABLE = "CREDENTIALS_DIRECTORY"  # systemd.exec(5), LoadCredential=


def with_credentials(address: str, file: Path | None) -> str:
    """Address with the user and password of a file, for the library that opens it and for nobody else.

    Parameters
    ----------
    address : str
        As in the settings.
    file : Path or None
        With the user in its first line and the password in its second. A file of that name among the service's
        credentials of systemd goes first.

    Raises
    ------
    CameraError
        The file cannot be read, is readable by everybody, or does not hold two lines.
    """
    if file is None:
        return address
    user, password = read_credentials(file)
    scheme, slashes, rest = address.partition("://")
    return f"{scheme}{slashes}{quote(user, safe='')}:{quote(password, safe='')}@{rest}"


def read_credentials(file: Path) -> tuple[str, str]:
    """User and password of a file; raises `CameraError` as `with_credentials` does."""
    place = _place(file)
    try:
        open_to_all = place.stat().st_mode & stat.S_IROTH
        lines = place.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not a text in UTF-8"
        raise CameraError(f"{place}: cannot be read ({reason}); give a file with user and password") from None
    if open_to_all:
        raise CameraError(f"{place}: everybody may read it; make it readable by the service only: chmod o-r")
    if len(lines) != 2 or not lines[0]:
        raise CameraError(f"{place}: {len(lines)} lines; write the user in the first and the password in the second")
    return lines[0], lines[1]


def _place(file: Path) -> Path:
    given = Path(os.environ.get(FOLDER_VARIABLE, os.devnull)) / file.name
    return given if given.is_file() else file
