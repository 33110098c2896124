"""What the views of one page share."""

from dataclasses import dataclass, field
from pathlib import Path

from appliance.page.access.attempts import Attempts
from appliance.page.access.logins import Logins
from appliance.page.access.users import Users
from appliance.page.commissioning import Commissioning
from appliance.page.previews import Previews
from appliance.page.watch import Watch


@dataclass(frozen=True, slots=True)
class Parts:
    """Everything that a view may read.

    Attributes
    ----------
    watch : Watch
    users : Users
    logins : Logins
    previews : Previews
    history : Path or None
        Folder of the history; None if nothing is kept.
    commissioning : Commissioning
    references : Path or None
        Folder of the ingots' references that the settings name.
    attempts : Attempts
    """

    watch: Watch
    users: Users
    logins: Logins
    previews: Previews
    history: Path | None
    commissioning: Commissioning
    references: Path | None = None
    attempts: Attempts = field(default_factory=Attempts)
