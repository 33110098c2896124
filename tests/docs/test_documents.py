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
DOCUMENTS = sorted(
    path for folder in ("", "docs/**/", "tests/**/", "benchmarks/**/") for path in REPOSITORY.glob(f"{folder}*.md")
)
ROOMS = ("appliance", "vision", "plc", "systemd", "tests", "benchmarks", "docs", ".ci")
PATH = re.compile(rf"`((?:{'|'.join(map(re.escape, ROOMS))})/[\w./-]+)`")


def name_of(path: Path) -> str:
    return str(path.relative_to(REPOSITORY))


@pytest.mark.parametrize("name", TEXTS)
def test_a_table_is_the_one_of_the_code(name):
    assert (TABLES / name).read_text(encoding="utf-8") == TEXTS[name], "run `make tables`"


@pytest.mark.parametrize("path", DOCUMENTS, ids=name_of)
def test_every_command_that_a_document_shows_exists_with_these_options(path):
    for line in re.findall(r"^(?:\$ )?(hotgauge .*)$", path.read_text(encoding="utf-8"), re.MULTILINE):
        words = shlex.split(line, comments=True)[1:]
        given = cli.parser().parse_args(words)
        assert given.run


def anchors(path: Path) -> set[str]:
    """Anchors of a document's headings, as they are made for Markdown on the web."""
    headings = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("path", DOCUMENTS, ids=name_of)
def test_every_relative_link_leads_to_a_file_and_to_a_heading_that_it_has(path):
    for target, anchor in re.findall(r"\]\((?!http)([^)#]*)#?([^)]*)\)", path.read_text(encoding="utf-8")):
        file = path.parent / target if target else path
        assert file.exists(), target
        assert not anchor or anchor in anchors(file), f"{target}#{anchor}"


@pytest.mark.parametrize("path", [one for one in DOCUMENTS if one.name != "CHANGELOG.md"], ids=name_of)
def test_every_path_of_the_repository_that_a_document_names_exists(path):
    for named in PATH.findall(path.read_text(encoding="utf-8")):
        assert (REPOSITORY / named).exists() or "NAME" in named, named


@pytest.mark.parametrize("name", ["CONTRIBUTING.md", "docs/architecture.md"])
def test_the_guides_name_the_files_that_they_lead_to(name):
    assert len(PATH.findall((REPOSITORY / name).read_text(encoding="utf-8"))) >= 20


def test_the_check_before_a_commit_runs_what_make_lint_runs():
    makefile, hooks = ((REPOSITORY / name).read_text() for name in ("Makefile", ".pre-commit-config.yaml"))
    linted = re.search(r"^lint:.*\n((?:\t.*\n)+)", makefile, re.MULTILINE)[1]
    for command in re.findall(r"\$\(BIN\)/(.+) \.$", linted, re.MULTILINE):
        assert f"entry: .venv/bin/{command}" in hooks
