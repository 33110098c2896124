"""Commands of the page for people: page, page-user."""

import argparse
import getpass
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from appliance.cli.common import add_config
from appliance.command_options import CommandError
from appliance.conformity.set_points import SetPoints
from appliance.files.runtime_folder import give_runtime_folder, runtime_folder
from appliance.service import systemd as service
from appliance.service.install import CONFIG, STATE
from appliance.supervisor import settings as settings_file
from appliance.supervisor.settings import Settings
from plc.security.roles import Role

if TYPE_CHECKING:
    from plc.poll import Place

USERS_FILE = "page_users.json"
_HERE = {"0.0.0.0": "127.0.0.1", "::": "::1"}  # noqa: S104  named, not bound


def run_page(given: argparse.Namespace) -> None:
    try:
        from appliance.page.commissioning import Commissioning
        from appliance.page.serve import serve_page
    except ImportError as error:
        advice = "pip install 'hotgauge[page]'"
        raise CommandError(f"the page needs more libraries ({error.name} is missing); {advice}") from error

    settings = settings_file.load(given.config)
    give_runtime_folder(settings.plc.port)
    service.start_log()
    page = settings.page
    scheme = "http" if page.certificate is None else "https"
    users = _users_file(settings, given.config)
    print(f"Hotgauge shows its page on {scheme}://{page.host}:{page.port}")
    print("  who may log in   hotgauge page-user NAME --role operator", flush=True)
    sizing = settings.sizing
    folder = page.commissioning or users.with_name("commissioning")
    rig = sizing.scale_file if sizing.method == "tangent" else None

    def refusal(sha256: str) -> str:
        return settings_file.load(given.config).sizing.adjustment.refusal(sha256)

    serve_page(
        page,
        place_of(settings),
        SetPoints.from_settings(sizing.set_points),
        users=users,
        previews=runtime_folder(),
        history=settings.history.directory,
        commissioning=Commissioning(folder, rig, given.config, refusal),
        references=settings.ingot.references,
    )


def add_page_user(command: argparse.ArgumentParser) -> None:
    command.add_argument("name", metavar="NAME")
    what = command.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--role",
        choices=[role.value for role in Role],
        help="what NAME may do; the password is asked for, or read from a pipe",
    )
    what.add_argument("--remove", action="store_true", help="NAME may log in no more")
    add_config(command)


def run_page_user(given: argparse.Namespace) -> None:
    try:
        from appliance.page.access.users import Users
    except ImportError as error:
        raise CommandError("users need more libraries; pip install 'hotgauge[page]'") from error

    installed = Path("/") / CONFIG
    config = given.config or (installed if installed.is_file() else None)
    users = Users(_users_file(settings_file.load(config), config))
    if given.remove:
        users.remove(given.name)
        print(f"{given.name} is taken out of {users.file}; log-ins end when the page is restarted")
        return
    users.put(given.name, Role(given.role), _password())
    print(f"{given.name} may log in as {given.role}; written to {users.file}")


def _password() -> str:
    if not sys.stdin.isatty():
        return sys.stdin.readline().rstrip("\n")
    password = getpass.getpass("Password: ")
    if getpass.getpass("Once more: ") != password:
        raise CommandError("the two passwords differ; try again")
    return password


def _users_file(settings: Settings, config: Path | None) -> Path:
    """File of the settings, else in the service's state directory, else in the user's own."""
    if settings.page.users is not None:
        return settings.page.users
    given = os.environ.get("STATE_DIRECTORY", "").partition(":")[0]
    if config == Path("/") / CONFIG:
        given = given or f"/{STATE}"
    own = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "hotgauge"
    return (Path(given) if given else own) / USERS_FILE


def place_of(settings: Settings) -> "Place":
    """Where the page finds the gauge of these settings: its secure port if it has a certificate for it."""
    from plc.poll import Place
    from plc.security.identity import TlsFiles

    plc, page = settings.plc, settings.page
    host = _HERE.get(plc.host, plc.host)
    if page.gauge_certificate is None or page.gauge_key is None:
        if not plc.plain:
            raise CommandError(
                "page.gauge_certificate: the gauge has only its secure port (plc.plain = false); set it and "
                "page.gauge_key to a client's from hotgauge certificates"
            )
        return Place(host, plc.port, plc.word_order)
    if plc.tls.authority is None:
        raise CommandError("page.gauge_certificate: the gauge has no secure port; set plc.tls, or leave it out")
    files = TlsFiles(page.gauge_certificate, page.gauge_key, plc.tls.authority)
    return Place(host, plc.tls.port, plc.word_order, files)
