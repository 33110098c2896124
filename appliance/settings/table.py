"""The table of all settings, derived from the sections; documents and error sentences are derived from it."""

import json
from collections.abc import Iterator
from typing import Any, NamedTuple, cast

from pydantic import BaseModel


class Kind(NamedTuple):
    """Kind of a section: the key that chooses it, as `sizing.camera.kind`, and the choice, as `oak`."""

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
        """Choices of `kinds`, as in `conveyor, recording`."""
        return ", ".join(kind.choice for kind in self.kinds)


def in_force(settings: BaseModel) -> list[tuple[SettingRow, str]]:
    """Settings of the kinds that are chosen, each with its value as written in TOML; empty if it is not set."""
    values = _flat(settings.model_dump(mode="json"), prefix="")
    rows = [row for row in table(type(settings)) if all(values.get(kind.key) == kind.choice for kind in row.kinds)]
    return [(row, as_toml(values[row.key])) for row in rows]


def _flat(section: dict[str, Any], prefix: str) -> dict[str, object]:
    values: dict[str, object] = {}
    for name, value in section.items():
        nested = isinstance(value, dict)
        values |= _flat(cast("dict[str, Any]", value), f"{prefix}{name}.") if nested else {prefix + name: value}
    return values


_JsonSchema = dict[str, Any]


def table(root: type[BaseModel]) -> tuple[SettingRow, ...]:
    """All settings, in the order of the file; documents and error sentences are derived from it."""
    schema = root.model_json_schema()
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
    """Rows of a section of several kinds; a row that all kinds share stands once, after those of single kinds."""
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
    default = "required" if required else as_toml(field["default"])
    return SettingRow(key, kinds, _allowed(field), default, unit, field["description"])


def as_toml(value: object) -> str:
    """Value as written in TOML; empty for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return json.dumps(value, ensure_ascii=False) if isinstance(value, (str, list)) else str(value)


def _allowed(field: _JsonSchema) -> str:
    choices = field.get("enum") or ([field["const"]] if "const" in field else [])
    if choices:
        return " or ".join(f'"{choice}"' for choice in choices)
    kind = field.get("anyOf", [field])[0]
    places = "a list [x, y, z]" if kind.get("minItems") == 3 else "a list [left, right]"
    lists = {"string": 'a list ["...", ...]', "number": places}
    names = {
        "integer": "a whole number",
        "number": "a number",
        "boolean": "true or false",
        "array": lists.get(_items(kind), "a list [x, y, width, height]"),
    }
    name = names.get(kind["type"], f"a {kind.get('format', 'text')}")
    return " ".join(part for part in (name, _bounds(kind), field.get("unit", "")) if part)


def _items(kind: _JsonSchema) -> str:
    return kind.get("items", {}).get("type", "")


def _bounds(kind: _JsonSchema) -> str:
    if "maximum" not in kind:
        return ""
    excluded = "exclusiveMinimum" in kind
    lower = f"above {kind['exclusiveMinimum']:g} up" if excluded else f"from {kind['minimum']:g}"
    return f"{lower} to {kind['maximum']:.12g}"
