"""Settings of the whole appliance: the root of the settings file, and those of the PLC's server."""

import os
from pathlib import Path
from typing import Literal

from pydantic import Field

from appliance.conformity.settings import CorrectionSettings, JudgingSettings
from appliance.history.settings import HistorySettings
from appliance.ingot.settings import IngotSettings
from appliance.settings.file import load as load_file
from appliance.settings.section import FilePath, Section, unit
from appliance.sizing.settings import Sizing
from appliance.sizing.stereo.settings import SizingSettings


class PlcSettings(Section):
    """The Modbus TCP server."""

    host: str = Field(default="127.0.0.1", description="Address to bind to; by default this computer only")
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


class Settings(Section):
    """Everything that can be set."""

    plc: PlcSettings = Field(default_factory=PlcSettings, description="Modbus TCP server")
    sizing: Sizing = Field(default_factory=SizingSettings, description="Sizing station")
    ingot: IngotSettings = Field(default_factory=IngotSettings, description="Ingot station")
    judging: JudgingSettings = Field(default_factory=JudgingSettings, description="Trust, cold size and bars")
    correction: CorrectionSettings = Field(default_factory=CorrectionSettings, description="Closed loop")
    history: HistorySettings = Field(default_factory=HistorySettings, description="What is kept on disk")


def state_folder(plc: PlcSettings) -> Path | None:
    """Folder for set points: from the settings, else the service manager's; None if nobody may write set points."""
    if plc.writes == "none":
        return None
    if plc.state_directory is not None:
        return plc.state_directory
    given = os.environ.get("STATE_DIRECTORY", "").partition(":")[0]
    return Path(given) if given else None


def load(path: Path | None) -> Settings:
    """Read the appliance's settings from a TOML file; None gives the defaults; raises `SettingsError`."""
    return load_file(path, Settings)
