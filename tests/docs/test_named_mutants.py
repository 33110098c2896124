"""Mutants of the dissertation: each can still be made, its tests exist, and the committed table has them all."""

import re
from pathlib import Path

import pytest
from mutants import audit

ROOT = Path(__file__).parents[2]
NAMED = list(audit.named(ROOT))


@pytest.mark.parametrize("one", NAMED, ids=lambda one: f"{one.item}, {one.change}")
def test_a_mutant_is_code_that_differs_and_its_tests_exist(one):
    compile(one.mutant.source, one.mutant.file, "exec")
    assert one.mutant.source != (ROOT / one.mutant.file).read_text(encoding="utf-8")
    for test in one.tests:
        file, _, name = test.partition("::")
        assert not name or re.search(rf"^def {name}\b", (ROOT / file).read_text(encoding="utf-8"), re.MULTILINE)
        assert (ROOT / file).exists()


def test_the_committed_table_has_every_mutant_and_each_is_killed():
    assert audit.FILE.with_suffix(".md").read_text(encoding="utf-8") == audit.table([(one, "killed") for one in NAMED])
