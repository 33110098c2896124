"""Settings of what leaves the gauge beside the PLC."""

from pydantic import Field

from appliance.settings.section import FilePath, Section, unit


class MetricsSettings(Section):
    """Figures for Prometheus, on a port of their own."""

    host: str = Field(default="127.0.0.1", description="Address to bind to; 0.0.0.0 is every IPv4 address")
    port: int = Field(default=0, ge=0, le=65535, description="TCP port; 0: none is served")


class MqttSettings(Section):
    """What the history gets, sent to a broker; kept in memory while it is away."""

    host: str = Field(default="", description="Name or address of the broker; empty: nothing is sent")
    port: int = Field(default=8883, ge=1, le=65535, description="TCP port of the broker; without TLS usually 1883")
    tls: bool = Field(default=True, description="Whether the connection is encrypted and the broker must prove itself")
    authority: FilePath | None = Field(
        default=None, description="Certificate of the broker's authority, PEM; without: those of this computer"
    )
    certificate: FilePath | None = Field(default=None, description="The gauge's own certificate, PEM, if it is asked")
    key: FilePath | None = Field(default=None, description="Its key, PEM, without a password")
    credentials: FilePath | None = Field(
        default=None, description="File with the user in the first line and the password in the second"
    )
    client: str = Field(default="hotgauge", min_length=1, description="Name of this gauge, known to the broker once")
    topic: str = Field(default="hotgauge", pattern=r"^[^+#]+$", description="Topics begin with this and a slash")
    waiting_max: int = Field(
        default=20_000,
        ge=100,
        le=60_000,
        description="Messages kept while the broker is away, readings at most half of them; more are dropped and "
        "counted. 20,000 need about 40 MB",
    )


class DeliverySettings(Section):
    """Settings of the process that delivers."""

    metrics: MetricsSettings = Field(default_factory=MetricsSettings)
    mqtt: MqttSettings = Field(default_factory=MqttSettings)
    memory_max_mb: int = Field(default=512, json_schema_extra=unit("MB"))

    @property
    def is_on(self) -> bool:
        """Whether there is anything to deliver."""
        return bool(self.metrics.port or self.mqtt.host)
