"""The settings file: what is accepted, what is refused and in which words, and the table of settings."""

from pathlib import Path

import pytest
from pydantic import TypeAdapter

from appliance.settings.file import SettingsError
from appliance.settings.table import in_force, table
from appliance.sizing.settings import Sizing
from appliance.sizing.stereo.settings import SizingSettings
from appliance.supervisor.settings import Settings, load


def written(folder: Path, text: str) -> Path:
    file = folder / "hotgauge.toml"
    file.write_text(text, encoding="utf-8")
    return file


def sentence(folder: Path, text: str) -> str:
    with pytest.raises(SettingsError) as caught:
        load(written(folder, text))
    return str(caught.value)


def test_every_default_works_without_a_file():
    assert load(None) == Settings()


def test_an_empty_file_gives_the_defaults(tmp_path):
    assert load(written(tmp_path, "")) == Settings()


def test_what_check_config_shows_can_be_loaded_again(tmp_path):
    text = "\n".join(f"{row.key} = {value}" for row, value in in_force(Settings()) if value)
    assert load(written(tmp_path, text)) == Settings()


def test_a_relative_path_starts_from_the_folder_of_the_file(tmp_path):
    settings = load(
        written(tmp_path, '[sizing]\nrig = "a/rig.json"\n[sizing.camera]\nkind = "recording"\npath = "/abs"\n')
    )
    assert settings.sizing.rig == tmp_path / "a" / "rig.json"
    assert settings.sizing.camera.path == Path("/abs")


def test_settings_survive_the_way_to_the_measuring_process(tmp_path):
    sizing = load(written(tmp_path, '[sizing.camera]\nkind = "recording"\npath = "x"\nrate_hz = 5\n')).sizing
    assert SizingSettings.model_validate_json(sizing.model_dump_json()) == sizing


CONVEYOR = '[sizing]\nmethod = "conveyor"\n[sizing.conveyor]\nbarrier_mm = 500\n'


def test_a_conveyor_takes_a_single_camera_and_what_check_config_shows_can_be_loaded_again(tmp_path):
    settings = load(written(tmp_path, CONVEYOR + 'background = "empty.png"\n[sizing.camera]\nkind = "oak"\n'))
    assert settings.sizing.camera.socket == "CAM_A"
    assert settings.sizing.conveyor.background == tmp_path / "empty.png"
    rows = [row.key for row, _ in in_force(settings)]
    assert "sizing.rig" not in rows
    assert len(set(rows)) == len(rows)
    again = load(written(tmp_path, "\n".join(f"{row.key} = {value}" for row, value in in_force(settings) if value)))
    assert again == settings
    assert TypeAdapter(Sizing).validate_json(settings.sizing.model_dump_json()) == settings.sizing


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("[plc]\nprot = 5020", ("plc.prot", "unknown key", "plc.port")),
        ("[plc]\nport = 70000", ("plc.port = 70000", "from 1 to 65535")),
        ('[plc]\nport = "5020"', ('plc.port = "5020"', "a whole number")),
        ('[plc]\nwrites = "maybe"', ('plc.writes = "maybe"', '"none" or "tls" or "all"')),
        ("[plc]\nhost = 1", ("plc.host = 1", "a text")),
        ("plc = 1", ("plc = 1", "a [section]")),
        ("[sizing]\ncamera = 1", ("sizing.camera", "a [section]")),
        ('[plc]\nport = "a\\nb"', ('plc.port = "a\\nb"', "a whole number")),
        ("[zebra]\na = 1", ("zebra", "unknown key", "[plc], [sizing]")),
        ("[sizing]\nstale_after_ms = 99", ("sizing.stale_after_ms = 99", "from 100 to 10000 ms")),
        (
            '[sizing.camera]\nkind = "oka"',
            ('sizing.camera.kind = "oka"', '"genicam" or "mill" or "oak" or "recording" or "stream"'),
        ),
        (
            "[sizing.camera]\nrate_hz = 5",
            ("sizing.camera.kind", "missing", '"genicam" or "mill" or "oak" or "recording" or "stream"'),
        ),
        (
            '[sizing.camera]\nkind = "genicam"\nleft = "1"\nright = "2"\ntrigger = "Action1"\nscheduled_ms = 20',
            ('scheduled_ms needs trigger = "Action1" and common_clock = true',),
        ),
        ('[sizing.camera]\nkind = "recording"', ("sizing.camera.path", "missing", "a path")),
        ('[sizing.camera]\nkind = "mill"\nrate_hz = 0', ("sizing.camera.rate_hz = 0", "above 0 up to 60 1/s")),
        ('[sizing.camera]\nkind = "mill"\nrate_hz = nan', ("sizing.camera.rate_hz = nan", "above 0 up to 60")),
        ('[sizing.camera]\nkind = "mill"\nloop = true', ("sizing.camera.loop", "unknown key", 'kind = "recording"')),
        ('[sizing]\nmethod = "conveyer"', ('sizing.method = "conveyer"', '"conveyor" or "tangent"')),
        ('[sizing]\nmethod = "conveyor"', ("sizing.conveyor", "missing", "a [section]")),
        (CONVEYOR.replace("barrier_mm", "barrier_height_mm"), ("sizing.conveyor.barrier_mm", "missing", "mm")),
        (
            CONVEYOR.replace("[", 'rig = "rig.json"\n[', 2).replace('rig = "rig.json"\n', "", 1),
            ("sizing.rig", "unknown key", 'sizing.method = "tangent"'),
        ),
        (
            CONVEYOR + '[sizing.camera]\nkind = "stream"\nleft = "a"\nright = "b"',
            ("sizing.camera.left", "unknown key", 'sizing.method = "tangent"', "sizing.camera.address", "missing"),
        ),
        ("[sizing.conveyor]\nbarrier_mm = 500", ("sizing.conveyor", "unknown key", 'sizing.method = "conveyor"')),
        ("[plc\n", ("not well-formed TOML", "line 1")),
    ],
)
def test_an_error_names_file_key_trouble_and_what_is_allowed(tmp_path, text, parts):
    said = sentence(tmp_path, text)
    assert said.startswith(f"{tmp_path / 'hotgauge.toml'}: ")
    for part in parts:
        assert part in said
    assert "\n" not in said


def test_every_trouble_of_a_file_is_named_at_once(tmp_path):
    said = sentence(tmp_path, "[plc]\nport = 0\nconnections_max = 0\n")
    assert "plc.port" in said
    assert "plc.connections_max" in said


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(SettingsError, match=r"absent\.toml: .*give an existing"):
        load(tmp_path / "absent.toml")


def test_a_file_that_is_no_text_is_named(tmp_path):
    file = tmp_path / "hotgauge.toml"
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SettingsError, match=r"hotgauge\.toml: not a text"):
        load(file)


NOT_SET = {
    "sizing.ovality_mm",
    "sizing.conveyor.barrier_lower_mm",
    "sizing.conveyor.response_exponent",
    "sizing.set_points.target_mm",
    "sizing.set_points.tolerance_plus_mm",
    "sizing.set_points.tolerance_minus_mm",
    "sizing.set_points.temperature_c",
    "sizing.camera.black_level",
    "ingot.camera.black_level",
    "sizing.camera.region",
    "ingot.camera.region",
}
"""Settings that nobody has to give and for which nothing stands."""


def test_every_setting_has_text_bounds_and_a_key_of_its_own():
    rows = table(Settings)
    assert len({(row.key, row.kind) for row in rows}) == len(rows)
    for row in rows:
        assert row.text
        assert row.allowed
        assert row.default or "path" in row.allowed or row.key in NOT_SET
        if "number" in row.allowed:
            assert " to " in row.allowed
            assert row.allowed.endswith(row.unit)
        assert not row.key.endswith(("_ms", "_hz")) or row.unit


REQUIRED = {
    ("sizing.method", "conveyor"): "sizing.conveyor.barrier_mm = 500\n",
    ("sizing.camera.kind", "conveyor, recording"): 'sizing.camera.path = "x"\n',
    ("sizing.camera.kind", "tangent, recording"): 'sizing.camera.path = "x"\n',
    ("ingot.camera.kind", "recording"): 'ingot.camera.path = "x"\n',
    ("sizing.camera.kind", "conveyor, stream"): 'sizing.camera.address = "a"\n',
    ("sizing.camera.kind", "tangent, stream"): 'sizing.camera.left = "a"\nsizing.camera.right = "b"\n',
    ("sizing.camera.kind", "conveyor, genicam"): 'sizing.camera.serial = "1"\n',
    ("sizing.camera.kind", "tangent, genicam"): 'sizing.camera.left = "1"\nsizing.camera.right = "2"\n'
    'sizing.camera.trigger = "Action1"\nsizing.camera.common_clock = true\n',  # which scheduled_ms needs
    ("sizing.range.kind", "tangent, modbus"): "".join(
        f"sizing.range.{line}\n"
        for line in ('host = "a"', "address = 0", "origin_mm = [0, 0, 0]", "direction = [0, 0, -1]", "u_mm = 0.5")
    ),
    ("ingot.camera.kind", "genicam"): 'ingot.camera.serial = "1"\n',
    ("ingot.camera.kind", "stream"): 'ingot.camera.address = "a"\n',
}
NUMBERS = [row for row in table(Settings) if "number" in row.allowed]


def number(text: str) -> float:
    """As TOML reads it: a whole number without a point."""
    return float(text) if "." in text else int(text)


COMPANIONS = {
    "sizing.adjustment.added_mm": {
        "sizing.adjustment.expanded_mm": 0.1,
        "sizing.adjustment.date": '"2026-11-28"',
        "sizing.adjustment.reason": '"master 250.00"',
        "sizing.adjustment.who": '"A. Smith"',
        "sizing.adjustment.calibration_sha256": f'"{"5e" * 32}"',
    },
    "history.verification_due_days": {"history.directory": '"history"'},
}
"""What must be given beside a key."""


def head_of(row) -> str:
    """Lines that make a row count; dotted keys, which may stand in any order."""
    lines = [f'{kind.key} = "{kind.choice}"\n' for kind in row.kinds]
    lines += [
        line
        for (key, kind), text in REQUIRED.items()
        if key in {one.key for one in row.kinds} and (kind == row.kind or kind == row.kinds[0].choice)
        for line in text.splitlines(keepends=True)
    ]
    lines += [f"{key} = {value}\n" for key, value in COMPANIONS.get(row.key, {}).items()]
    return "".join(line for line in lines if not line.startswith(f"{row.key} ="))


@pytest.mark.parametrize("row", NUMBERS, ids=lambda row: f"{row.key}-{row.kind}")
def test_the_bounds_in_the_table_are_the_bounds_that_hold(tmp_path, row):
    *_, lower, _, upper = row.allowed.removesuffix(row.unit).replace(" up ", " ").split()
    head, name = head_of(row), row.key
    load(written(tmp_path, f"{head}{name} = {upper}"))
    too_low = float(lower) if "above" in row.allowed else number(lower) - 1
    for outside in (number(upper) + 1, too_low):
        assert row.allowed in sentence(tmp_path, f"{head}{name} = {outside}")


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        ("[judging]\ntolerance_mm = 0.5", "did you mean sizing.set_points.tolerance_"),
        ("[plc]\nprot = 5020", "did you mean plc.port?"),
        ("[judging]\ntrust_mim = 5", "did you mean judging.trust_min?"),
        ("[plc]\nzzz = 1", "known here: plc.connections_max"),
    ],
)
def test_a_key_that_is_not_known_gets_the_one_that_was_meant_or_none(tmp_path, text, advice):
    file = tmp_path / "gauge.toml"
    file.write_text(text)
    with pytest.raises(SettingsError) as refused:
        load(file)
    assert advice in str(refused.value)
