"""Commands about the computer that the gauge runs on: check-config, install, doctor."""

import argparse
import socket
from pathlib import Path

from appliance.command_options import CommandError
from appliance.settings.masking import mask
from appliance.settings.table import in_force
from appliance.supervisor import settings as settings_file
from appliance.supervisor.settings import PlcSettings
from plc.security.addresses import served_in_words

EXIT_CHECKS_FAILED = 1


def add_check_config(command: argparse.ArgumentParser) -> None:
    command.add_argument("config", type=Path, nargs="?", metavar="FILE", help="settings in TOML")


def run_check_config(given: argparse.Namespace) -> None:
    from appliance.service.checks import FOR_THE_START

    settings = settings_file.load(given.config)
    file = given.config or "the defaults"
    served = _served(settings.plc, file)
    for check in FOR_THE_START:
        if (found := check(settings)).verdict == "BAD":
            raise CommandError(f"{file}: {found.name}: {found.text}")
    print(f"# {file}: good; {served}; in force:")
    for row, value in in_force(settings):
        print(f"{row.key} = {mask(value)}  # {row.allowed}; {row.text}" if value else f"# {row.key}  # {row.text}")


def _served(plc: PlcSettings, file: object) -> str:
    """What the server would serve; raises where the host is unknown here, or a certificate cannot be used."""
    from plc.security.identity import CertificateError, Identity

    try:
        socket.getaddrinfo(plc.host, None)
        if plc.tls.files is not None:
            Identity.load(plc.tls.files)
    except socket.gaierror as error:
        advice = "give an address of this computer, or a name that it knows"
        raise CommandError(f"{file}: plc.host: no host {plc.host} is known here; {advice}") from error
    except CertificateError as error:
        raise CommandError(f"{file}: {error}") from error
    return f"it serves {served_in_words(plc.host)}"


def add_install(command: argparse.ArgumentParser) -> None:
    command.add_argument("--remove", action="store_true", help="take the service down again instead")
    command.add_argument("--root", type=Path, default=Path("/"), metavar="DIR", help="write below this folder only")


def run_install(given: argparse.Namespace) -> None:
    from appliance.service.install import install, remove

    lines = (remove if given.remove else install)(given.root)
    print(next(lines, f"{given.root}: nothing that install writes is there"))
    for line in lines:
        print(line)


def add_cameras(_: argparse.ArgumentParser) -> None:
    """Nothing but the command itself."""


def run_cameras(_: argparse.Namespace) -> None:
    from appliance.cameras.connected import connected_cameras

    for line in connected_cameras():
        print(line, flush=True)


def run_doctor(given: argparse.Namespace) -> int | None:
    from appliance.service.doctor import examine
    from appliance.service.install import CONFIG

    installed = Path("/") / CONFIG
    config = given.config or (installed if installed.is_file() else None)
    bad = 0
    for check in examine(config):
        print(check, flush=True)
        bad += check.verdict == "BAD"
    return EXIT_CHECKS_FAILED if bad else None
