"""Writes the tables of this folder from the code that they describe: `make tables`."""

import logging
from pathlib import Path

from appliance.archives.parquet import ERROR, RECORDING
from appliance.conformity.thermal_expansion import GRADES
from appliance.delivery.alert_rules import rules_file
from appliance.diagnostics.alarms import ALARMS
from appliance.diagnostics.fault_table import FAULTS
from appliance.diagnostics.named_bits import named_bits
from appliance.history.tables import TABLES, Column, Table
from appliance.ingot.frame_rows import FRAME_COLUMNS as ORIENT_COLUMNS
from appliance.ingot.frame_rows import INGOT_COLUMNS
from appliance.settings.table import table
from appliance.simulation.bars.study_scenes import CONDITIONS
from appliance.simulation.ingots.conditions import INGOT_CONDITIONS
from appliance.sizing.conveyor.plots import EXPERIMENT_COLUMNS
from appliance.sizing.reading_rows import FRAME_COLUMNS
from appliance.sizing.set_points import STEELS
from appliance.supervisor.settings import Settings
from plc.export import to_markdown
from vision.reasons import INGOT_REASONS, REASONS

FOLDER = Path(__file__).parent


def texts() -> dict[str, str]:
    """Every table as Markdown, by file name."""
    return {
        "registers.md": to_markdown(named_bits()),
        "settings.md": settings(),
        "reasons.md": reasons(),
        "faults.md": faults(),
        "scenes.md": scenes(),
        "alarms.md": alarms(),
        "grades.md": grades(),
        "history.md": history(),
        "prometheus_alerts.yml": rules_file(),
        "outputs.md": outputs(),
    }


def settings() -> str:
    """All settings, in the order of the file."""
    rows = [
        (f"`{row.key}`" + (f" ({row.kind})" if row.kind else ""), row.allowed, row.default or "not set", row.text)
        for row in table(Settings)
    ]
    return _document("Settings", "One TOML file, checked by `hotgauge check-config FILE`.", _SETTINGS_HEAD, rows)


def reasons() -> str:
    """All reason flags, lowest bit first."""
    rows = [
        (str(row.flag.bit_length() - 1), f"`{row.name}`", "no value" if row.forbids_value else "less trust", row.text)
        for row in REASONS
    ]
    intro = "Bits of `reason_word`, and names in the files of `hotgauge measure`."
    bars = _document("Reason flags", intro, ("bit", "name", "means", "text"), rows)
    rows = [
        (str(row.flag.bit_length() - 1), f"`{row.name}`", "no end" if row.forbids_value else "a note", row.text)
        for row in INGOT_REASONS
    ]
    intro = "Bits of `ingot_reason_word`, and names in the files of `hotgauge orient`."
    ingots = _document("Reason flags of ingots", intro, ("bit", "name", "means", "text"), rows)
    return f"{bars}\n#{ingots}"


def faults() -> str:
    """The fault table."""
    rows = [
        (
            str(row.code),
            f"`{row.name}`",
            str(row.bit),
            row.state.name.lower().replace("_", " "),
            logging.getLevelName(row.severity).lower(),
            "until acknowledged" if row.latching else "",
            row.text,
            row.remedy,
        )
        for row in FAULTS
    ]
    intro = (
        "Trouble with the equipment. `device_state` is the NE 107 class of the worst active one; a bit of `fault_word` "
        "is set as long as its fault is active, and where it says so until the PLC acknowledges."
    )
    head = ("code", "name", "bit of `fault_word`", "device state", "severity", "latches", "text", "remedy")
    return _document("Faults", intro, head, rows)


def scenes() -> str:
    """What the simulated mill can draw."""
    rows = [(f"`{row.name}`", row.kind, row.text) for row in CONDITIONS]
    rows += [(f"`ingots-{row.name}`", "ingots", row.text) for row in INGOT_CONDITIONS]
    intro = (
        "Scenes of the simulated mill: `hotgauge simulate --output DIR --scene CONDITION --effect EFFECT`. "
        "Those of ingots take no effect, and `ingots` alone is `ingots-mixed`."
    )
    return _document("Scenes", intro, ("name", "kind", "text"), rows)


def alarms() -> str:
    """The alarm table, by coil."""
    rows = [
        (
            str(coil),
            f"`{row.name}`",
            row.priority,
            ", ".join(f"`{cause}`" for cause in row.causes),
            f"{row.on_delay_s:g}",
            f"{row.off_delay_s:g}",
            row.text,
            row.remedy,
        )
        for coil, row in enumerate(ALARMS)
    ]
    intro = "Alarms after ISA-18.2, by coil. A cause is a fault of the fault table or a condition of the process."
    head = ("coil", "name", "priority", "causes", "on-delay, s", "off-delay, s", "text", "remedy")
    return _document("Alarms", intro, head, rows)


def grades() -> str:
    """The expansion table at three temperatures."""
    temperatures_c = (1000, 1100, 1200)
    rows = [
        (
            str(number),
            grade.name,
            *(f"{100 * grade.elongation(temperature_c):.2f} %" for temperature_c in temperatures_c),
        )
        for number, grade in GRADES.items()
    ]
    head = ("expansion_grade", "steel", *(f"elongation at {temperature_c} °C" for temperature_c in temperatures_c))
    expansion = _document("Steel grades", "How much larger steel is than at 20 °C, by EN 1993-1-2:2005.", head, rows)
    steels = [(str(number), ", ".join(name for name, grade in STEELS.items() if grade == number)) for number in GRADES]
    intro = (
        "Names for `sizing.set_points.grade`; names and classes after EN 10025-2, EN 10083, EN 10084, EN ISO 683-17, "
        "EN 10088-1 and AISI, numbers after EN 10027-2. Capitals and blanks do not matter."
    )
    return f"{expansion}\n#{_document('Names of steels', intro, ('expansion_grade', 'names'), steels)}"


def outputs() -> str:
    """Columns of the files that commands write."""
    intro = (
        "Keys of the JSON lines and columns of the CSV that commands write; those of `hotgauge export` stand in "
        "[history](history.md), those of `hotgauge poll` are names of [registers](registers.md), in CSV with "
        "`written_` before what the PLC has set. What does not exist is null, or an empty "
        "cell; flags are a list, in CSV joined by `;`; true and false are `true` and `false`."
    )
    parts = [
        ("hotgauge measure", "One row for each frame.", FRAME_COLUMNS),
        (
            "hotgauge measure, a folder of recordings",
            "`NAME.parquet`: one row for each frame of each recording, with two columns more than those above.",
            (RECORDING, ERROR),
        ),
        (
            "hotgauge measure, plots of the conveyor method",
            "`experiments.csv` in the folder of `--plot`: one row for each frame that an experiment could size.",
            EXPERIMENT_COLUMNS,
        ),
        (
            "hotgauge orient, frames",
            "One row for each frame: JSON lines with the key `frame`, or `NAME.csv`.",
            ORIENT_COLUMNS,
        ),
        (
            "hotgauge orient, ingots",
            "One row for each ingot once it is decided or gone: JSON lines with the key `ingot`, or `NAME-ingots.csv`.",
            INGOT_COLUMNS,
        ),
    ]
    tables = [
        "#" + _document(title, text, ("column", "unit", "text"), [(f"`{c.name}`", c.unit, c.text) for c in columns])
        for title, text, columns in parts
    ]
    return f"# Files that commands write\n\n{intro}\n\n" + "\n".join(tables)


def history() -> str:
    """The tables of the history, as `hotgauge export` writes them."""
    intro = (
        "What `hotgauge export --what TABLE` writes. Each time is two columns, `..._utc` and `..._local`; what is "
        "not known is empty. Rows are selected by the first column."
    )
    return f"# Tables of the history\n\n{intro}\n\n" + "\n".join(map(_history_table, TABLES))


def _exported_name(column: Column) -> str:
    return column.name.removesuffix("_ms") if column.kind == "time" else column.name


def _history_table(table: Table) -> str:
    rows = [(f"`{_exported_name(column)}`", column.unit, column.text) for column in table.columns]
    name = table.name.replace("_", "-")
    return "#" + _document(name, table.text, ("column", "unit", "text"), rows)


_SETTINGS_HEAD = ("key", "allowed", "default", "text")


def _document(title: str, intro: str, head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    body = "\n".join("| " + " | ".join(line) + " |" for line in lines)
    return f"# {title}\n\n{intro}\n\n{body}\n"


if __name__ == "__main__":
    for name, text in texts().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
