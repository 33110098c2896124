"""The command line's manners: version, help with examples that work, completion, loud and quiet."""

import shlex
import subprocess

import pytest
from running import HOTGAUGE

from appliance.cli import main as cli
from appliance.cli.examples import EXAMPLES

COLUMNS = 80


def test_every_command_has_examples():
    assert EXAMPLES.keys() == cli.COMMANDS.keys()


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_help_fits_the_terminal_and_its_examples_are_commands(name, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(COLUMNS))
    with pytest.raises(SystemExit) as ended:
        cli.main([name, "--help"])
    assert ended.value.code == 0
    text = capsys.readouterr().out
    assert max(map(len, text.splitlines())) <= COLUMNS
    for example in EXAMPLES[name]:
        assert example in text
        words = shlex.split(example.partition(" > ")[0])
        assert words[:2] == ["hotgauge", name]
        assert cli.parser().parse_args(words[1:]).run


def test_the_version_is_told(capsys):
    with pytest.raises(SystemExit) as ended:
        cli.main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith("hotgauge 0.")


def test_a_shell_completes_commands_and_options(tmp_path):
    script = subprocess.run([HOTGAUGE, "--completion", "bash"], capture_output=True, text=True, check=True).stdout
    file = tmp_path / "hotgauge.bash"
    file.write_text(script)
    ask = f"source {file}; COMP_WORDS=(hotgauge cal); COMP_CWORD=1; _shtab_hotgauge; echo ${{COMPREPLY[@]}}"
    said = subprocess.run(["bash", "-c", ask], capture_output=True, text=True, check=True)
    assert said.stdout.split() == ["calibrate"]


def test_where_an_error_arose_is_shown_when_it_is_asked_for_and_not_otherwise(capsys):
    assert cli.main(["check-config", "/nowhere.toml"]) == 2
    assert "Traceback" not in capsys.readouterr().err
    assert cli.main(["-v", "check-config", "/nowhere.toml"]) == 2
    assert "Traceback" in capsys.readouterr().err
