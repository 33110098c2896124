"""The command certificates: a small private authority for the secure port."""

import argparse
import os
import re
import socket
from pathlib import Path

from appliance.command_options import CommandError
from plc.security.addresses import check_host
from plc.security.roles import Role

_CLIENT = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,59}")
_OWN = ("localhost", "127.0.0.1", "::1")


def add_certificates(command: argparse.ArgumentParser) -> None:
    command.add_argument("--output", type=Path, required=True, metavar="DIR", help="folder of the authority")
    command.add_argument(
        "--host", action="append", default=[], metavar="HOST", help="name or address by which clients know the gauge"
    )
    command.add_argument("--client", metavar="NAME", help="make a client's certificate too, named so")
    command.add_argument("--role", choices=[role.value for role in Role], help="what this client may do")


def run_certificates(given: argparse.Namespace) -> None:
    from plc.security.identity import CertificateError

    _check(given)
    try:
        for line in _make(given):
            print(line)
    except CertificateError as error:
        raise CommandError(str(error)) from error
    except OSError as error:
        raise CommandError(
            f"{error.filename}: {os.strerror(error.errno or 0)}; give --output a folder to write"
        ) from error


def _check(given: argparse.Namespace) -> None:
    if (given.client is None) != (given.role is None):
        raise CommandError("--client and --role belong together: give both, or neither for the gauge's own certificate")
    if given.client is not None and not _CLIENT.fullmatch(given.client):
        raise CommandError(f"--client: {given.client!r} cannot be; give letters, digits, dots and dashes, 60 at most")
    for host in given.host:
        try:
            check_host(host)
        except ValueError as error:
            raise CommandError(f"--host: {error}") from error


def _make(given: argparse.Namespace) -> list[str]:
    from plc.security.certificates import AUTHORITY_DAYS, CERTIFICATE_DAYS, Authority

    folder: Path = given.output
    files: list[Path] = []
    if (folder / "authority.pem").exists():
        authority = Authority.load(folder)
    else:
        authority = Authority.make()
        files += authority.save(folder)
    if given.client is None or not (folder / "server.pem").exists():
        files += authority.server(folder, list(dict.fromkeys([*given.host, socket.gethostname(), *_OWN])))
    if given.client is not None:
        files += authority.client(folder, given.client, Role(given.role))
    years = (
        f"the authority is valid for {AUTHORITY_DAYS // 365} years, other certificates for {CERTIFICATE_DAYS // 365}"
    )
    return [*(f"wrote {file}" for file in files), years, *_advice(folder)]


def _advice(folder: Path) -> list[str]:
    return [
        "keep authority.key away from the gauge: who has it can make certificates of every role",
        "for the gauge:  [plc.tls]",
        *(
            f'                {setting} = "{(folder / file).absolute()}"'
            for setting, file in (("certificate", "server.pem"), ("key", "server.key"), ("authority", "authority.pem"))
        ),
        "for a client:   authority.pem, and client-NAME.pem and client-NAME.key of its own",
    ]
