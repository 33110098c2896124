"""Writes the studies' figures into the documents that state them: `make tables`.

A line `<!-- table: NAME -->` stands before each table; NAME is a row of TABLES (`tables.py`). Of the sentences of
SENTENCES (`sentences.py`) the numbers are written, the words stay.
"""

import re
from pathlib import Path

from results import Rows, Sentence
from sentences import SENTENCES
from tables import TABLES

REPOSITORY = Path(__file__).parents[2]
METHODS = sorted((REPOSITORY / "docs" / "methods").glob("*.md"))
MARKED = re.compile(r"(<!-- table: (.+) -->\n)((?:\|.*\n)*)")
NUMBER = r"([-+]?\d+(?:\.\d+)?)"


def texts() -> dict[Path, str]:
    """Every document that states figures of studies, with the figures that the results have."""
    stating = {REPOSITORY / sentence.document for sentence in SENTENCES}
    return {path: with_sentences(path, with_tables(path.read_text("utf-8"))) for path in sorted({*METHODS, *stating})}


def with_tables(text: str) -> str:
    """A document's text with each marked table drawn anew."""
    return MARKED.sub(lambda found: found[1] + _markdown(TABLES[found[2]]()), text)


def _markdown(rows: Rows) -> str:
    head, *body = rows
    return "".join("| " + " | ".join(row) + " |\n" for row in (head, ("---",) * len(head), *body))


def with_sentences(path: Path, text: str) -> str:
    """A document's text with the numbers of its sentences written anew."""
    for sentence in SENTENCES:
        if REPOSITORY / sentence.document == path:
            text = with_numbers(text, sentence)
    return text


def with_numbers(text: str, sentence: Sentence) -> str:
    """A text with the numbers of one sentence written anew; it may be broken into lines anywhere.

    Raises
    ------
    ValueError
        The sentence does not stand there exactly once, or has another count of places than of numbers.
    """
    words = re.escape(sentence.text).replace(r"\ ", r"\s+").replace(r"\{\}", NUMBER)
    found = list(re.finditer(words, text))
    if len(found) != 1:
        raise ValueError(f"{sentence.document} has {len(found)} times: {sentence.text}")
    numbers = sentence.numbers()
    for place, number in reversed(list(enumerate(numbers, 1))):
        text = text[: found[0].start(place)] + number + text[found[0].end(place) :]
    if len(numbers) != found[0].re.groups:
        raise ValueError(f"{len(numbers)} numbers for: {sentence.text}")
    return text


if __name__ == "__main__":
    for path, text in texts().items():
        path.write_text(text, encoding="utf-8")
