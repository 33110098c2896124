"""What all sections of the settings file have in common."""

from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, JsonValue, ValidationInfo
from pydantic_core import PydanticCustomError


class Section(BaseModel):
    """A section: no unknown keys, no values of a wrong type, not changed once it is read."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


def unit(unit: str) -> dict[str, JsonValue]:
    """What a field's schema says of its unit."""
    return {"unit": unit}


def refusal(why: str) -> PydanticCustomError:
    """What a validator raises that can say itself what is wrong and what to do."""
    return PydanticCustomError("setting", "{why}", {"why": why})


def _beside_the_file(path: Path, info: ValidationInfo) -> Path:
    return info.context["folder"] / path if info.context else path


FilePath = Annotated[Path, Field(strict=False), AfterValidator(_beside_the_file)]
"""A path; a relative one in a settings file starts from that file's folder."""
