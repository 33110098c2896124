"""The view of commissioning: calibrate the sizing cameras, verify them with a master bar, and confirm."""

from collections.abc import Mapping
from typing import Any

from appliance.page.commissioning import Commissioning, CommissioningError

MASTER_MAX_MM = 10_000.0


def values(commissioning: Commissioning, query: Mapping[str, str]) -> dict[str, Any]:
    """What the view shows.

    Parameters
    ----------
    commissioning : Commissioning
    query : mapping of str to str
        `folder`: the one that is worked on; without: the last of the list.
    """
    names = commissioning.names(with_boards=True)
    wanted = query.get("folder", "")
    name = wanted if wanted in names else (names[-1] if names else "")
    steps = commissioning.steps(name) if name else {}
    return {
        "place": str(commissioning.folder),
        "rig": "" if commissioning.rig is None else str(commissioning.rig),
        "names": names,
        "name": name,
        "recordings": commissioning.names(with_boards=False),
        "running": commissioning.running,
        "steps": {step: steps.get(step) for step in ("calibrated", "verified")},
        "log": commissioning.log(),
    }


def act(commissioning: Commissioning, step: str, form: Mapping[str, str], who: str) -> None:
    """Do one step of a form.

    Parameters
    ----------
    commissioning : Commissioning
    step : {"calibrate", "verify", "confirm"}
    form : mapping of str to str
    who : str

    Raises
    ------
    CommissioningError
    """
    name = form.get("folder", "")
    if step == "calibrate":
        commissioning.calibrate(name, who)
    elif step == "verify":
        sizes = _length(form, "diameter"), _length(form, "expanded")
        commissioning.verify(name, who, form.get("recording", ""), *sizes)
    else:
        commissioning.confirm(name, who)


def _length(form: Mapping[str, str], key: str) -> float:
    text = form.get(key, "")
    try:
        number = float(text.replace(",", "."))
    except ValueError:
        number = -1.0
    if not 0 <= number < MASTER_MAX_MM:
        raise CommissioningError(f"{text!r}: no length; give millimetres, as 120.05")
    return number
