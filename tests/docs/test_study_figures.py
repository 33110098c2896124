"""Figures that documents state are those of the studies' results."""

import re
import runpy
from pathlib import Path

import pytest

STUDIES = Path(__file__).parents[2] / "docs" / "studies"
WRITER = runpy.run_path(str(STUDIES))
TEXTS = WRITER["texts"]()
MARKED = [
    (path, name) for path in TEXTS for name in re.findall(r"^<!-- table: (.+) -->$", path.read_text(), re.MULTILINE)
]


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.name)
def test_tables_and_sentences_have_the_figures_of_the_studies_results(path):
    assert path.read_text(encoding="utf-8") == TEXTS[path], "run `make tables`"


def test_every_table_that_can_be_written_stands_in_one_document():
    assert sorted(name for _, name in MARKED) == sorted(WRITER["TABLES"])


@pytest.mark.parametrize(("path", "name"), MARKED, ids=lambda one: one if isinstance(one, str) else "")
def test_a_changed_figure_of_a_table_is_written_anew(path, name):
    text = TEXTS[path]
    row = text.split(f"<!-- table: {name} -->\n")[1].splitlines()[2]
    assert WRITER["with_tables"](text.replace(row, re.sub(r"\d", "7", row))) == text


@pytest.mark.parametrize("sentence", WRITER["SENTENCES"], ids=lambda one: one.numbers.__name__)
def test_a_changed_figure_of_a_sentence_is_written_anew(sentence):
    said = sentence.text.format(*sentence.numbers())
    changed = sentence.text.format(*("777" for _ in sentence.numbers()))
    assert WRITER["with_numbers"](changed.replace(" ", "\n"), sentence) == said.replace(" ", "\n")


def test_a_sentence_that_nobody_says_any_more_is_found_out():
    sentence = WRITER["SENTENCES"][0]
    with pytest.raises(ValueError, match=f"{sentence.document} has 0 times"):
        WRITER["with_numbers"]("Something else.", sentence)
