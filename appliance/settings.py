"""All settings of the appliance: one TOML file, every field with its text, unit and bounds.

Every default works without a file. Unknown keys are refused. The table in the documents is derived from here.
"""

import difflib
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, NamedTuple, cast

from pydantic import Field, ValidationError
from pydantic_core import ErrorDetails

from appliance.ingot_settings import IngotSettings
from appliance.sections import FilePath, Section, unit
from appliance.sizing_settings import Sizing, SizingSettings


class SettingsError(Exception):
    """The settings file cannot be used; the message names file, key, what is wrong and what is allowed."""


class PlcSettings(Section):
    """The Modbus TCP server."""

    host: str = Field(default="127.0.0.1", description="Address to bind to; loopback unless told otherwise")
    port: int = Field(default=5020, ge=1, le=65535, description="TCP port of the Modbus server")
    writes: Literal["none", "tls", "all"] = Field(
        default="none",
        description="Who may write set points and commands: nobody, TLS clients with a role, or everybody",
    )
    word_order: Literal["big", "little"] = Field(
        default="big",
        description="Order of the words in values of more than one word; big is most significant first",
    )
    connections_max: int = Field(default=64, ge=1, le=1000, description="Clients served at once")
    silent_after_s: float = Field(
        default=5.0,
        ge=1,
        le=3600,
        description="Time without a change of plc_heartbeat, once it was written, that is an alarm",
        json_schema_extra=unit("s"),
    )
    state_directory: FilePath | None = Field(
        default=None,
        description="Folder that keeps set points over a restart; without: the service manager's, or none",
    )


class JudgingSettings(Section):
    """How a diameter is judged."""

    trust_min: float = Field(
        default=50.0,
        ge=0,
        le=100,
        description="Trust below which alarm_low_trust comes and correction is 0",
        json_schema_extra=unit("%"),
    )
    temperature_u_c: float = Field(
        default=25.0,
        ge=0,
        le=200,
        description="Standard uncertainty of steel_temperature as the section's mean",
        json_schema_extra=unit("°C"),
    )
    bar_gap_ms: int = Field(
        default=300,
        ge=0,
        le=60000,
        description="Time without a bar that parts two bars",
        json_schema_extra=unit("ms"),
    )


class CorrectionSettings(Section):
    """The advised change of the stand's gap."""

    gain: float = Field(default=0.5, ge=0, le=2, description="Share of the deviation that is corrected")
    dead_band_mm: float = Field(
        default=0.1, ge=0, le=10, description="Deviation that is left alone", json_schema_extra=unit("mm")
    )
    rate_mm_per_s: float = Field(
        default=0.5, gt=0, le=100, description="Fastest change of correction", json_schema_extra=unit("mm/s")
    )
    limit_mm: float = Field(
        default=1.0, ge=0, le=50, description="Largest correction either way", json_schema_extra=unit("mm")
    )


class Settings(Section):
    """Everything that can be set."""

    plc: PlcSettings = Field(default_factory=PlcSettings, description="Modbus TCP server")
    sizing: Sizing = Field(default_factory=SizingSettings, description="Sizing station")
    ingot: IngotSettings = Field(default_factory=IngotSettings, description="Ingot station")
    judging: JudgingSettings = Field(default_factory=JudgingSettings, description="Trust, cold size and bars")
    correction: CorrectionSettings = Field(default_factory=CorrectionSettings, description="Closed loop")


def load(path: Path | None) -> Settings:
    """Read and check a settings file.

    Parameters
    ----------
    path : Path or None
        TOML file; None gives the defaults.

    Returns
    -------
    Settings

    Raises
    ------
    SettingsError
        File missing or unreadable, TOML not well-formed, key unknown, value of a wrong type or out of bounds.
    """
    if path is None:
        return Settings()
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8"))
        return Settings.model_validate(values, context={"folder": path.parent})
    except OSError as error:
        raise SettingsError(f"{path}: {error.strerror}; give an existing TOML file") from error
    except UnicodeDecodeError as error:
        raise SettingsError(f"{path}: not a text in UTF-8; give a TOML file") from error
    except tomllib.TOMLDecodeError as error:
        raise SettingsError(f"{path}: not well-formed TOML: {error}") from error
    except ValidationError as error:
        raise SettingsError(f"{path}: " + "; ".join(_sentence(detail) for detail in error.errors())) from error


class Kind(NamedTuple):
    """A choice between kinds of a section: the key that names the kind, and the kind named."""

    key: str
    choice: str

    def __str__(self) -> str:
        return f'{self.key} = "{self.choice}"'


class SettingRow(NamedTuple):
    """One row of the table of all settings.

    Attributes
    ----------
    key : str
        Dotted path, as in `sizing.camera.rate_hz`.
    kinds : tuple of Kind
        Kinds of sections that have this key, outermost first; empty where every kind has it.
    allowed : str
        Type with bounds and unit, or the choices.
    default : str
        As written in TOML; empty where there is none, `required` where one must be given.
    unit : str
        Empty for a plain number or text.
    text : str
    """

    key: str
    kinds: tuple[Kind, ...]
    allowed: str
    default: str
    unit: str
    text: str

    @property
    def kind(self) -> str:
        """Its kinds in words, as in `conveyor, recording`."""
        return ", ".join(kind.choice for kind in self.kinds)


def in_force(settings: Settings) -> list[tuple[SettingRow, str]]:
    """Every setting that counts with these settings, and its value as written in TOML (empty: not set)."""
    values = _flat(settings.model_dump(mode="json"), prefix="")
    rows = [row for row in table() if all(values.get(kind.key) == kind.choice for kind in row.kinds)]
    return [(row, _as_toml(values[row.key])) for row in rows]


def _flat(section: dict[str, Any], prefix: str) -> dict[str, object]:
    values: dict[str, object] = {}
    for name, value in section.items():
        nested = isinstance(value, dict)
        values |= _flat(cast("dict[str, Any]", value), f"{prefix}{name}.") if nested else {prefix + name: value}
    return values


_JsonSchema = dict[str, Any]


def table() -> tuple[SettingRow, ...]:
    """All settings, in the order of the file; documents and error sentences are derived from it."""
    schema = Settings.model_json_schema()
    return tuple(_rows(schema, schema["$defs"], prefix="", kinds=()))


def _rows(section: _JsonSchema, sections: _JsonSchema, prefix: str, kinds: tuple[Kind, ...]) -> Iterator[SettingRow]:
    for name, field in section["properties"].items():
        key = prefix + name
        if "$ref" in field:
            yield from _rows(sections[_section_name(field["$ref"])], sections, f"{key}.", kinds)
        elif "discriminator" in field:
            yield from _rows_of_kinds(field["discriminator"], sections, key, kinds)
        else:
            yield _row(key, kinds, field, required=name in section.get("required", ()))


def _rows_of_kinds(
    discriminator: _JsonSchema, sections: _JsonSchema, key: str, kinds: tuple[Kind, ...]
) -> Iterator[SettingRow]:
    """Rows of a section of several kinds; what every kind has alike is one row."""
    kind_key = f"{key}.{discriminator['propertyName']}"
    by_kind = [
        list(_rows(sections[_section_name(reference)], sections, f"{key}.", (*kinds, Kind(kind_key, choice))))
        for choice, reference in discriminator["mapping"].items()
    ]
    alike = [
        [row._replace(kinds=kinds) if len(row.kinds) == len(kinds) + 1 else row for row in rows] for rows in by_kind
    ]
    common = set(alike[0]).intersection(*alike[1:])
    for rows, bare in zip(by_kind, alike, strict=True):
        yield from (row for row, shared in zip(rows, bare, strict=True) if shared not in common)
    yield from (row for row in alike[0] if row in common)


def _section_name(reference: str) -> str:
    return reference.rpartition("/")[2]


def _row(key: str, kinds: tuple[Kind, ...], field: _JsonSchema, *, required: bool) -> SettingRow:
    unit = field.get("unit", "")
    default = "required" if required else _as_toml(field["default"])
    return SettingRow(key, kinds, _allowed(field), default, unit, field["description"])


def _as_toml(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else str(value)


def _allowed(field: _JsonSchema) -> str:
    choices = field.get("enum") or ([field["const"]] if "const" in field else [])
    if choices:
        return " or ".join(f'"{choice}"' for choice in choices)
    kind = field.get("anyOf", [field])[0]
    names = {
        "integer": "a whole number",
        "number": "a number",
        "boolean": "true or false",
        "array": "a list [x, y, width, height]",
    }
    name = names.get(kind["type"], f"a {kind.get('format', 'text')}")
    return " ".join(part for part in (name, _bounds(field), field.get("unit", "")) if part)


def _bounds(field: _JsonSchema) -> str:
    if "maximum" not in field:
        return ""
    excluded = "exclusiveMinimum" in field
    lower = f"above {field['exclusiveMinimum']:g} up" if excluded else f"from {field['minimum']:g}"
    return f"{lower} to {field['maximum']:.12g}"


def _sentence(detail: ErrorDetails) -> str:
    rows = table()
    key, kinds = _place(detail["loc"], rows)
    if detail["type"] == "extra_forbidden":
        return f"{key}: unknown key; {_nearest(key, kinds, rows)}"
    given = detail["input"]
    if detail["type"].startswith("union_tag"):
        context = detail.get("ctx", {})
        key, given = f"{key}.{context['discriminator'].strip(chr(39))}", context.get("tag")
    here = [row for row in rows if row.key == key and not _elsewhere(row, kinds)]
    allowed = " or ".join(dict.fromkeys(row.allowed for row in here)) or "a [section]"
    missing = detail["type"] in {"missing", "union_tag_not_found"}
    return f"{key}: missing; give {allowed}" if missing else f"{key} = {_as_toml(given)} cannot be; give {allowed}"


def _place(location: tuple[int | str, ...], rows: tuple[SettingRow, ...]) -> tuple[str, tuple[Kind, ...]]:
    """Key of an error, and the kinds of the sections around it, which stand behind their sections."""
    choosing = {kind.key.rpartition(".")[0]: kind.key for row in rows for kind in row.kinds}
    key, kinds, chosen = "", list[Kind](), False
    for part in map(str, location):
        chosen = key in choosing and not chosen
        if chosen:
            kinds.append(Kind(choosing[key], part))
        else:
            key = f"{key}.{part}" if key else part
    return key, tuple(kinds)


def _elsewhere(row: SettingRow, kinds: tuple[Kind, ...]) -> list[Kind]:
    """Kinds that a row needs in place of those that are there."""
    there = dict(kinds)
    return [kind for kind in row.kinds if there.get(kind.key, kind.choice) != kind.choice]


def _nearest(key: str, kinds: tuple[Kind, ...], rows: tuple[SettingRow, ...]) -> str:
    section = key.rpartition(".")[0]
    wanted = [_elsewhere(row, kinds) for row in rows if row.key == key or row.key.startswith(f"{key}.")]
    if wanted:
        return f"it needs {' and '.join(map(str, min(wanted, key=len)))}; leave it out"
    keys = sorted({row.key for row in rows})
    near = difflib.get_close_matches(key, keys, n=1)
    if near:
        return f"did you mean {near[0]}?"
    here = [other for other in keys if other.startswith(f"{section}.")] or [
        f"[{name}]" for name in Settings.model_fields
    ]
    return "known here: " + ", ".join(here)
