"""The table of texts is whole: every key that the page uses, in every language, and none that it does not."""

import re
from pathlib import Path

import pytest

import appliance.page
from appliance.diagnostics.alarms import ALARMS
from appliance.diagnostics.fault_table import FAULTS
from appliance.page.texts import LANGUAGES, Texts, table
from plc.codes import CODES
from vision.reasons import INGOT_REASONS, REASONS

FOLDER = Path(appliance.page.__file__).parent
MADE = re.compile(
    r"decision_\d|state_\d|priority_\w+|ingot_(top|bottom|undecided|none)|figure_\w+|camera_(left|right)|station_\w+|"
    r"(viewer|operator|engineer)|(line|cameras|registers|history|commission)|light_\w+|\w+_block|log_in|step_\w+|wanted_\w+|\w+_said|quality_\w+"
)
"""Keys that are put together, or handed on as names."""


def test_every_text_is_there_in_every_language():
    for key, texts in table()["page"].items():
        assert len(texts) == len(LANGUAGES), key
        assert all(texts), key
        fields = [set(re.findall(r"{(\w+)}", text)) for text in texts]
        assert fields[0] == fields[1], key


@pytest.mark.parametrize(
    ("section", "names", "columns"),
    [
        ("alarms", [row.name for row in ALARMS], 2),
        ("faults", [row.name for row in FAULTS], 2),
        ("reasons", [row.name for row in (*REASONS, *INGOT_REASONS)], 1),
        ("codes", [code.text for codes in CODES.values() for code in codes], 1),
    ],
)
def test_german_is_there_for_every_row_of_the_tables(section, names, columns):
    german = table()[section]
    assert german.keys() == set(names)
    assert all(len(texts) == columns for texts in german.values())


def test_every_key_that_the_page_names_is_in_the_table_and_every_key_of_the_table_is_named():
    sources = [*FOLDER.rglob("*.py"), *FOLDER.rglob("*.html")]
    text = "\n".join(path.read_text(encoding="utf-8") for path in sources)
    used = {key for key in re.findall(r"""texts\(["'](\w+)["']""", text) if not key.endswith("_")}
    assert used <= table()["page"].keys()
    quoted = set(re.findall(r"""["'](\w+)["']""", text))
    unused = {key for key in table()["page"].keys() - quoted if not MADE.fullmatch(key)}
    assert unused == set()


def test_a_number_in_german_has_a_comma():
    assert Texts("de").number(1234.5, 1) == "1234,5"
    assert Texts("en").number(None) == "–"
