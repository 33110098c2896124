"""All settings of the appliance: one TOML file, every field with its text, unit and bounds.

Every default works without a file. Unknown keys are refused. The table in the documents is derived from here.
"""

import difflib
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, cast

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, JsonValue, ValidationError, ValidationInfo
from pydantic_core import ErrorDetails


class SettingsError(Exception):
    """The settings file cannot be used; the message names file, key, what is wrong and what is allowed."""


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


def _unit(unit: str) -> dict[str, JsonValue]:
    return {"unit": unit}


def _beside_the_file(path: Path, info: ValidationInfo) -> Path:
    return info.context["folder"] / path if info.context else path


FilePath = Annotated[Path, Field(strict=False), AfterValidator(_beside_the_file)]
"""A path; a relative one in a settings file starts from that file's folder."""


class PlcSettings(_Section):
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
        json_schema_extra=_unit("s"),
    )
    state_directory: FilePath | None = Field(
        default=None,
        description="Folder that keeps set points over a restart; without: the service manager's, or none",
    )


class MillCamera(_Section):
    """The simulated mill as camera."""

    kind: Literal["mill"] = Field(default="mill", description="A simulated mill, for trying and testing")
    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="Seed of bars and noise")
    rate_hz: float = Field(
        default=10.0, gt=0, le=60, description="Image pairs per second", json_schema_extra=_unit("1/s")
    )
    prepared_frames: int = Field(
        default=0,
        ge=0,
        le=600,
        description="Frames drawn before the start and then played as a loop, at any rate; 0 draws as it goes",
    )


class RecordingCamera(_Section):
    """A recording as camera."""

    kind: Literal["recording"] = Field(description="Pictures recorded before")
    path: FilePath = Field(description="Folder with left/ and right/ pictures, or left.mp4 and right.mp4")
    rate_hz: float = Field(
        default=10.0,
        ge=0,
        le=1000,
        description="Image pairs per second; 0 plays as fast as the gauge takes them",
        json_schema_extra=_unit("1/s"),
    )
    loop: bool = Field(default=True, description="Start again at the end")


Camera = Annotated[MillCamera | RecordingCamera, Field(discriminator="kind")]


class LivenessSettings(_Section):
    """When the pictures of the cameras are no longer believed."""

    lost_after_ms: int = Field(
        default=700,
        ge=100,
        le=10000,
        description="Time without a picture that counts (new, in step, not blank) after which it is a fault",
        json_schema_extra=_unit("ms"),
    )
    apart_max_us: int = Field(
        default=5000,
        ge=1,
        le=1000000,
        description="Longest time between left and right exposure of a pair, by their device time stamps",
        json_schema_extra=_unit("µs"),
    )
    blank_level: int = Field(
        default=2,
        ge=0,
        le=255,
        description="Steps of grey by which nearly all pixels of a blank picture stay within its median",
    )
    interval_max_ms: int = Field(
        default=500,
        ge=10,
        le=60000,
        description="Mean time between pairs above which they come too slowly",
        json_schema_extra=_unit("ms"),
    )
    dropped_max_percent: float = Field(
        default=75.0,
        ge=0,
        le=100,
        description="Share of dropped pairs that is a fault",
        json_schema_extra=_unit("%"),
    )
    idle_after_s: float = Field(
        default=15.0,
        ge=1,
        le=600,
        description="Time that a measuring process may run without a reading and without a fault",
        json_schema_extra=_unit("s"),
    )


class SizingSettings(_Section):
    """The sizing station."""

    camera: Camera = Field(default_factory=MillCamera, description="Where image pairs come from")
    rig: FilePath | None = Field(
        default=None,
        description="Calibration of the two cameras, from `hotgauge calibrate`; the mill can do without",
    )
    ovality_mm: float = Field(
        default=0.0,
        ge=0,
        le=20,
        description="Greatest minus least width of a section that the product may have; part of the uncertainty",
        json_schema_extra=_unit("mm"),
    )
    stale_after_ms: int = Field(
        default=800,
        ge=100,
        le=10000,
        description="Age from which a reading is no value any more",
        json_schema_extra=_unit("ms"),
    )
    memory_max_mb: int = Field(
        default=2048,
        ge=256,
        le=65536,
        description="Memory of each measuring process, above which it ends and is started again",
        json_schema_extra=_unit("MB"),
    )
    liveness: LivenessSettings = Field(default_factory=LivenessSettings, description="When pictures are believed")


class JudgingSettings(_Section):
    """How a diameter is judged."""

    trust_min: float = Field(
        default=50.0,
        ge=0,
        le=100,
        description="Trust below which alarm_low_trust comes and correction is 0",
        json_schema_extra=_unit("%"),
    )
    temperature_u_c: float = Field(
        default=25.0,
        ge=0,
        le=200,
        description="Standard uncertainty of steel_temperature as the section's mean",
        json_schema_extra=_unit("°C"),
    )
    bar_gap_ms: int = Field(
        default=300,
        ge=0,
        le=60000,
        description="Time without a bar that parts two bars",
        json_schema_extra=_unit("ms"),
    )


class CorrectionSettings(_Section):
    """The advised change of the stand's gap."""

    gain: float = Field(default=0.5, ge=0, le=2, description="Share of the deviation that is corrected")
    dead_band_mm: float = Field(
        default=0.1, ge=0, le=10, description="Deviation that is left alone", json_schema_extra=_unit("mm")
    )
    rate_mm_per_s: float = Field(
        default=0.5, gt=0, le=100, description="Fastest change of correction", json_schema_extra=_unit("mm/s")
    )
    limit_mm: float = Field(
        default=1.0, ge=0, le=50, description="Largest correction either way", json_schema_extra=_unit("mm")
    )


class Settings(_Section):
    """Everything that can be set."""

    plc: PlcSettings = Field(default_factory=PlcSettings, description="Modbus TCP server")
    sizing: SizingSettings = Field(default_factory=SizingSettings, description="Sizing station")
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


class SettingRow(NamedTuple):
    """One row of the table of all settings.

    Attributes
    ----------
    key : str
        Dotted path, as in `sizing.camera.rate_hz`.
    kind : str
        The `kind` of the section that has this key; empty where the section has no kinds.
    allowed : str
        Type with bounds and unit, or the choices.
    default : str
        As written in TOML; empty where there is none, `required` where one must be given.
    unit : str
        Empty for a plain number or text.
    text : str
    """

    key: str
    kind: str
    allowed: str
    default: str
    unit: str
    text: str


def in_force(settings: Settings) -> list[tuple[SettingRow, str]]:
    """Every setting that counts with these settings, and its value as written in TOML (empty: not set)."""
    values = _flat(settings.model_dump(mode="json"), prefix="")
    rows = [row for row in table() if not row.kind or values[f"{row.key.rpartition('.')[0]}.kind"] == row.kind]
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
    return tuple(_rows(schema, schema["$defs"], prefix="", kind=""))


def _rows(section: _JsonSchema, sections: _JsonSchema, prefix: str, kind: str) -> Iterator[SettingRow]:
    for name, field in section["properties"].items():
        key = prefix + name
        if "$ref" in field:
            yield from _rows(sections[_section_name(field["$ref"])], sections, f"{key}.", kind)
        elif "discriminator" in field:
            for choice, reference in field["discriminator"]["mapping"].items():
                yield from _rows(sections[_section_name(reference)], sections, f"{key}.", choice)
        else:
            yield _row(key, kind, field, required=name in section.get("required", ()))


def _section_name(reference: str) -> str:
    return reference.rpartition("/")[2]


def _row(key: str, kind: str, field: _JsonSchema, *, required: bool) -> SettingRow:
    unit = field.get("unit", "")
    default = "required" if required else _as_toml(field["default"])
    return SettingRow(key, kind, _allowed(field), default, unit, field["description"])


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
    names = {"integer": "a whole number", "number": "a number", "boolean": "true or false"}
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
    kinds = {row.kind for row in rows if row.kind}
    key = ".".join(str(part) for part in detail["loc"] if part not in kinds)
    if detail["type"] == "extra_forbidden":
        return f"{key}: unknown key; {_nearest(key, rows)}"
    given = detail["input"]
    if detail["type"].startswith("union_tag"):
        key, given = f"{key}.kind", detail.get("ctx", {}).get("tag")
    kind = next((part for part in detail["loc"] if part in kinds), "")
    choices = dict.fromkeys(row.allowed for row in rows if row.key == key and row.kind.startswith(str(kind)))
    allowed = " or ".join(choices) or "a [section]"
    missing = detail["type"] in {"missing", "union_tag_not_found"}
    return f"{key}: missing; give {allowed}" if missing else f"{key} = {_as_toml(given)} cannot be; give {allowed}"


def _nearest(key: str, rows: tuple[SettingRow, ...]) -> str:
    section = key.rpartition(".")[0]
    keys = sorted({row.key for row in rows})
    near = difflib.get_close_matches(key, keys, n=1)
    if near:
        return f"did you mean {near[0]}?"
    here = [other for other in keys if other.startswith(f"{section}.")] or [
        f"[{name}]" for name in Settings.model_fields
    ]
    return "known here: " + ", ".join(here)
