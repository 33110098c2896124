"""Reports as PDF, which needs Debian's Pango: an overview and one page for each shift, whatever the shift was like."""

import re
import subprocess
from datetime import UTC, datetime

import pytest
from mill_history import MillHistory

from appliance.cli.main import main
from appliance.diagnostics.alarms import ALARMS
from appliance.diagnostics.fault_table import FAULTS
from appliance.history import database
from appliance.history.tables import Row

pytestmark = pytest.mark.waiting

START = datetime(2026, 6, 1, 6, tzinfo=UTC)
START_MS = round(1000 * START.timestamp())
MINUTE_MS = 60_000


@pytest.fixture
def config(tmp_path):
    (tmp_path / "hotgauge.toml").write_text('[history]\ndirectory = "history"\n')
    return tmp_path / "hotgauge.toml"


def save(config, rows: list[Row]) -> None:
    connection = database.open_to_write(config.parent / "history" / database.FILE_NAME)
    database.write(connection, rows)
    connection.close()


def report(config, output, *more: str) -> int:
    words = ["report", "--from", "2026-06-01T06:00Z", "--to", "2026-06-01T14:00Z", "--output", str(output)]
    return main([*words, "--config", str(config), *more])


def pages(pdf) -> int:
    said = subprocess.run(["pdfinfo", pdf], capture_output=True, text=True, check=True).stdout
    return int(re.search(r"^Pages: +(\d+)$", said, re.MULTILINE)[1])


def test_pdf_has_an_overview_and_a_page_for_each_shift(config, tmp_path):
    rows: list[Row] = []
    MillHistory(rows.append, START).run(3)
    save(config, rows)
    assert report(config, tmp_path / "shift.pdf") == 0
    assert pages(tmp_path / "shift.pdf") == 1
    assert report(config, tmp_path / "shifts.pdf", "--shift-hours", "4") == 0
    assert pages(tmp_path / "shifts.pdf") == 3


def test_a_shift_with_all_that_can_be_wrong_still_fits_on_its_page(config, tmp_path):
    rows = [Row("runs", {"started_utc_ms": START_MS, "alive_utc_ms": START_MS + 500 * MINUTE_MS, "version": "1.2.3"})]
    for number in range(400):
        deviation_mm, out = (number % 9) / 3, number % 4 == 0
        values: dict = {"started_utc_ms": START_MS + MINUTE_MS * number, "run_utc_ms": START_MS, "bar": number}
        values |= {"target_mm": 100.0 + number % 8, "tolerance_plus_mm": 2.0, "tolerance_minus_mm": 1.0}
        values |= {
            "deviation_mm": deviation_mm,
            "decision": 2 if out else 1,
            "product_id": 4294967294,
            "simulated": True,
        }
        parts = dict.fromkeys(("head_mm", "body_mm", "tail_mm"), 123.456) | {"expanded_uncertainty_mm": 0.123}
        rows.append(Row("bars", values | parts))
    for table, events in (("alarms", ALARMS), ("faults", FAULTS)):
        for number, event in enumerate(events):
            values = {"came_utc_ms": START_MS + MINUTE_MS * number, "run_utc_ms": START_MS, "name": event.name}
            rows.append(Row(table, values | ({"state": 4, "station": ""} if table == "faults" else {})))
    sha = {"file": "/etc/hotgauge/" + "rig" * 20 + ".json", "sha256": "0" * 64}
    rows.append(Row("calibrations", {"found_utc_ms": START_MS, "run_utc_ms": START_MS, **sha}))
    save(config, rows)
    assert report(config, tmp_path / "bad.pdf") == 0
    assert pages(tmp_path / "bad.pdf") == 1
