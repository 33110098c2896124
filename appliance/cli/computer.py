"""Commands about the computer that the gauge runs on: check-config, install, doctor."""

import argparse
from pathlib import Path

from appliance.settings.masking import mask
from appliance.settings.table import in_force
from appliance.supervisor import settings as settings_file

EXIT_CHECKS_FAILED = 1


def add_check_config(command: argparse.ArgumentParser) -> None:
    command.add_argument("config", type=Path, nargs="?", metavar="FILE", help="settings in TOML")


def run_check_config(given: argparse.Namespace) -> None:
    settings = settings_file.load(given.config)
    print(f"# {given.config or 'the defaults'}: good; in force:")
    for row, value in in_force(settings):
        print(f"{row.key} = {mask(value)}  # {row.allowed}; {row.text}" if value else f"# {row.key}  # {row.text}")


def add_install(command: argparse.ArgumentParser) -> None:
    command.add_argument("--remove", action="store_true", help="take the service down again instead")
    command.add_argument("--root", type=Path, default=Path("/"), metavar="DIR", help="write below this folder only")


def run_install(given: argparse.Namespace) -> None:
    from appliance.service.install import install, remove

    for line in (remove if given.remove else install)(given.root):
        print(line)


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
