"""Settings of the whole appliance: the root of the settings file, and those of the PLC's server."""

import os
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationInfo

from appliance.conformity.settings import CorrectionSettings, JudgingSettings
from appliance.delivery.settings import MetricsSettings, MqttSettings
from appliance.history.settings import HistorySettings
from appliance.ingot.settings import IngotSettings
from appliance.page.settings import PageSettings
from appliance.settings.file import load as load_file
from appliance.settings.section import FilePath, Section, unit
from appliance.sizing.settings import Sizing
from appliance.sizing.stereo.settings import SizingSettings
from plc.security.addresses import Network, check_host
from plc.security.identity import TlsFiles


class TlsSettings(Section):
    """Modbus/TCP Security: served when certificate, key and authority are given."""

    port: int = Field(default=802, ge=1, le=65535, description="TCP port of Modbus/TCP Security")
    certificate: FilePath | None = Field(default=None, description="The gauge's certificate, PEM")
    key: FilePath | None = Field(default=None, description="Key of the gauge's certificate, PEM, without a password")
    authority: FilePath | None = Field(default=None, description="Certificate of the authority of its clients, PEM")

    @property
    def files(self) -> TlsFiles | None:
        """The three files; None when there is no secure port."""
        if self.certificate is None or self.key is None or self.authority is None:
            return None
        return TlsFiles(self.certificate, self.key, self.authority)


def _writers(texts: list[str]) -> list[str]:
    for text in texts:
        Network.parse(text)
    return texts


def _tls(tls: TlsSettings, info: ValidationInfo) -> TlsSettings:
    """Check that the secure port has all of its files if it has one, or is needed."""
    given = [tls.certificate, tls.key, tls.authority]
    if any(given) and not all(given):
        raise ValueError("certificate, key and authority belong together; give all three, or none")
    if tls.files is not None:
        if info.data.get("port") == tls.port and info.data.get("plain"):
            raise ValueError(f"port {tls.port} is that of plc.port too; give another")
        return tls
    advice = "give certificate, key and authority (hotgauge certificates makes them)"
    if info.data.get("writes") == "tls":
        raise ValueError(f'plc.writes = "tls" needs it; {advice}, or set plc.writes')
    if info.data.get("plain") is False:
        raise ValueError(f"plc.plain = false leaves no port without it; {advice}, or set plc.plain")
    return tls


class PlcSettings(Section):
    """The Modbus TCP server."""

    host: Annotated[str, AfterValidator(check_host)] = Field(
        default="127.0.0.1",
        description="Address or name to bind to; :: is every address, 0.0.0.0 every IPv4 address",
    )
    port: int = Field(default=5020, ge=1, le=65535, description="TCP port of the Modbus server")
    plain: bool = Field(default=True, description="Whether this port, without TLS, is served at all")
    writes: Literal["none", "tls", "all"] = Field(
        default="none",
        description="Who may write set points and commands: nobody, TLS clients with a role, or everybody",
    )
    writers: Annotated[list[str], AfterValidator(_writers)] = Field(
        default=[],
        description="Addresses and networks that may write, on both ports; []: every address",
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
        description="Time without a change of plc_heartbeat, once the PLC has written it, before an alarm",
        json_schema_extra=unit("s"),
    )
    shelving_min: float = Field(
        default=30.0,
        gt=0,
        le=480,
        description="Time after which a shelved alarm is shown again",
        json_schema_extra=unit("min"),
    )
    state_directory: FilePath | None = Field(
        default=None,
        description="Folder in which set points survive a restart; not set: the folder that systemd provides, or none",
    )
    tls: Annotated[TlsSettings, AfterValidator(_tls)] = Field(
        default_factory=TlsSettings, validate_default=True, description="Modbus/TCP Security"
    )


class Settings(Section):
    """Everything that can be set."""

    plc: PlcSettings = Field(default_factory=PlcSettings, description="Modbus TCP server")
    sizing: Sizing = Field(default_factory=SizingSettings, description="Sizing station")
    ingot: IngotSettings = Field(default_factory=IngotSettings, description="Ingot station")
    judging: JudgingSettings = Field(default_factory=JudgingSettings, description="Trust, cold size and bars")
    correction: CorrectionSettings = Field(default_factory=CorrectionSettings, description="Closed loop")
    metrics: MetricsSettings = Field(default_factory=MetricsSettings, description="Figures for Prometheus")
    mqtt: MqttSettings = Field(default_factory=MqttSettings, description="Rows of the history for a broker")
    history: HistorySettings = Field(default_factory=HistorySettings, description="What is kept on disk")
    page: PageSettings = Field(default_factory=PageSettings, description="The page for people")


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
