"""Setting up over a service that runs: both units have the new program, and the settings stay."""

from pathlib import Path

import pytest

from appliance.service import install as setting_up


@pytest.fixture
def commands(monkeypatch) -> list[tuple[str, ...]]:
    """Commands of a set-up of this computer, of which none is run and nothing is written."""
    run: list[tuple[str, ...]] = []
    for name in ("_check_computer", "_reload_udev"):
        monkeypatch.setattr(setting_up, name, lambda: None)
    monkeypatch.setattr(setting_up, "_compile", lambda cache: f"compiled into {cache}")
    monkeypatch.setattr(setting_up, "_write", lambda path, _, keep: f"{'kept' if keep else 'wrote'} {path}")
    monkeypatch.setattr(setting_up, "_run", lambda *words: run.append(tuple(map(str, words))))
    return run


def test_users_and_folders_are_made_from_the_files_that_say_which(commands):
    list(setting_up.install(Path("/")))
    assert ("systemd-sysusers", "/etc/sysusers.d/hotgauge.conf") in commands
    assert ("systemd-tmpfiles", "--create", "/etc/tmpfiles.d/hotgauge.conf") in commands


@pytest.mark.parametrize("unit", ["hotgauge.service", "hotgauge-page.service"])
def test_a_unit_that_runs_is_started_anew_after_systemd_has_read_its_file(commands, unit):
    said = list(setting_up.install(Path("/")))
    units = [words for words in commands if words[:2] == ("systemctl", "daemon-reload") or words[-1] == unit]
    assert [words[1] for words in units] == ["daemon-reload", "enable", "restart"]
    assert "--now" not in units[1], "of a unit that runs it changes nothing"
    assert "kept /etc/hotgauge/hotgauge.toml" in said
