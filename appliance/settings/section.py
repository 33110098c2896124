"""Base of all sections of the settings file, their units, and paths relative to the file."""

from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, JsonValue, ValidationInfo


class Section(BaseModel):
    """A section: unknown keys and values of a wrong type are refused; a section never changes once it is read."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


def unit(unit: str) -> dict[str, JsonValue]:
    """Entry of a field's JSON schema that holds its unit."""
    return {"unit": unit}


def _beside_the_file(path: Path, info: ValidationInfo) -> Path:
    return info.context["folder"] / path if info.context else path


FilePath = Annotated[Path, Field(strict=False), AfterValidator(_beside_the_file)]
"""A path; in a settings file a relative one starts at that file's folder."""
