"""The documents say what the code does."""

import re
import runpy
import shlex
from pathlib import Path

import pytest

from appliance.cli import main as cli

REPOSITORY = Path(__file__).parents[2]
TABLES = REPOSITORY / "docs" / "tables"
TEXTS = runpy.run_path(str(TABLES / "__main__.py"))["texts"]()
DOCUMENTS = sorted([*REPOSITORY.glob("*.md"), *(REPOSITORY / "docs").rglob("*.md")])


@pytest.mark.parametrize("name", TEXTS)
def test_a_table_is_the_one_of_the_code(name):
    assert (TABLES / name).read_text(encoding="utf-8") == TEXTS[name], "run `make tables`"


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_every_command_that_a_document_shows_exists_with_these_options(path):
    for line in re.findall(r"^(?:\$ )?(hotgauge .*)$", path.read_text(encoding="utf-8"), re.MULTILINE):
        words = shlex.split(line, comments=True)[1:]
        given = cli.parser().parse_args(words)
        assert given.run


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_every_link_of_a_document_leads_somewhere(path):
    for target in re.findall(r"\]\((?!http)([^)#]+)", path.read_text(encoding="utf-8")):
        assert (path.parent / target).exists(), target
