"""What is wanted of a bar as long as the PLC has not written it, and the names of steels.

Carbon and low-alloy steels: names of EN 10025-2, EN 10083-2 and -3, EN 10084, EN ISO 683-17 and of AISI, with the
numbers of EN 10027-2. Austenitic steels: those that EN 10088-1:2014 lists as austenitic. The elongation of all steels
of a row is that of EN 1993-1-2:2005 (see `thermal_expansion`): no two laws within a row.
"""

import difflib
from typing import Annotated

from pydantic import AfterValidator, Field

from appliance.settings.section import Section, unit

CARBON, AUSTENITIC = 1, 2

STEELS: dict[str, int] = {
    **dict.fromkeys(
        (
            "S235JR", "1.0038", "S355J2", "1.0577", "C22", "1.0402", "C35", "1.0501", "C45", "1.0503", "C60", "1.0601",
            "28Mn6", "1.1170", "34Cr4", "1.7033", "41Cr4", "1.7035", "25CrMo4", "1.7218", "34CrMo4", "1.7220",
            "40CrMo4", "42CrMo4", "1.7225", "50CrMo4", "1.7228", "34CrNiMo6", "1.6582", "30CrNiMo8", "1.6580",
            "51CrV4", "1.8159", "16MnCr5", "1.7131", "20MnCr5", "1.7147", "18CrNiMo7-6", "1.6587", "100Cr6", "1.3505",
            "AISI 1045", "AISI 4130", "AISI 4140", "AISI 4340", "AISI 8620", "AISI 52100",
        ),
        CARBON,
    ),
    **dict.fromkeys(
        (
            "X5CrNi18-10", "1.4301", "X2CrNi18-9", "1.4307", "X6CrNiTi18-10", "1.4541", "X8CrNiS18-9", "1.4305",
            "X5CrNiMo17-12-2", "1.4401", "X2CrNiMo17-12-2", "1.4404", "X6CrNiMoTi17-12-2", "1.4571",
            "AISI 304", "AISI 304L", "AISI 303", "AISI 316", "AISI 316L", "AISI 321",
        ),
        AUSTENITIC,
    ),
}  # fmt: skip
"""Row of the expansion table by name or number."""

_BY_PLAIN_NAME = {name.casefold().replace(" ", ""): grade for name, grade in STEELS.items()}


def grade_of(name: str) -> int | None:
    """Row of the expansion table of a steel; None for a steel that is not known.

    Parameters
    ----------
    name : str
        Name or number; capitals and blanks do not matter.
    """
    return _BY_PLAIN_NAME.get(name.casefold().replace(" ", ""))


def _steel(name: str) -> str:
    if name and grade_of(name) is None:
        near = difflib.get_close_matches(name, STEELS, n=1)
        advice = f"did you mean {near[0]}?" if near else "give a name of the table of grades, as 42CrMo4 or 1.4301"
        raise ValueError(f"{name!r} is no steel that is known; {advice}")
    return name


class SetPointSettings(Section):
    """What is wanted of a bar as long as the PLC has not written it; the sizes are cold if a grade is in force."""

    target_mm: float | None = Field(
        default=None, ge=10, le=655.34, description="Wanted diameter", json_schema_extra=unit("mm")
    )
    tolerance_plus_mm: float | None = Field(
        default=None,
        ge=0.01,
        le=50,
        description="Largest allowed diameter minus the target",
        json_schema_extra=unit("mm"),
    )
    tolerance_minus_mm: float | None = Field(
        default=None,
        ge=0.01,
        le=50,
        description="Target minus the smallest allowed diameter",
        json_schema_extra=unit("mm"),
    )
    grade: Annotated[str, AfterValidator(_steel)] = Field(
        default="", description="Steel by its name or number, as in the table of grades; empty: not set"
    )
    temperature_c: float | None = Field(
        default=None,
        ge=100,
        le=1400,
        description="Mean temperature of the section",
        json_schema_extra=unit("°C"),
    )
