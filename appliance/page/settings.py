"""Settings of the page."""

import ipaddress
from typing import Annotated, Self

from pydantic import AfterValidator, Field, model_validator

from appliance.settings.section import FilePath, Section, unit
from plc.security.addresses import check_host


class PageSettings(Section):
    """The page for people; it is served by `hotgauge page`, a process of its own."""

    host: Annotated[str, AfterValidator(check_host)] = Field(
        default="127.0.0.1", description="Address or name that the page is served on; another than loopback needs TLS"
    )
    port: int = Field(default=8080, ge=1, le=65535, description="TCP port of the page")
    certificate: FilePath | None = Field(default=None, description="The page's certificate, PEM; with it: TLS")
    key: FilePath | None = Field(default=None, description="Its key, PEM, without a password")
    users: FilePath | None = Field(
        default=None, description="File of those who may log in; without: one in the state directory"
    )
    commissioning: FilePath | None = Field(
        default=None, description="Folder of board pictures for commissioning; without: one beside the file of users"
    )
    login_max_h: float = Field(
        default=12.0, gt=0, le=720, description="Time after which a log-in ends", json_schema_extra=unit("h")
    )
    idle_max_min: float = Field(
        default=30.0,
        gt=0,
        le=1440,
        description="Time without a click after which the log-in of an operator or engineer ends; viewers only look",
        json_schema_extra=unit("min"),
    )
    gauge_certificate: FilePath | None = Field(
        default=None, description="Certificate by which the page reads and writes the gauge's secure port, PEM"
    )
    gauge_key: FilePath | None = Field(default=None, description="Its key, PEM, without a password")

    @model_validator(mode="after")
    def _check_pairs(self) -> Self:
        if (self.certificate is None) != (self.key is None):
            raise ValueError("certificate and key belong together; give both, or neither")
        if (self.gauge_certificate is None) != (self.gauge_key is None):
            raise ValueError("gauge_certificate and gauge_key belong together; give both, or neither")
        if self.certificate is None and not _is_loopback(self.host):
            raise ValueError(
                f"host {self.host} sends passwords over the network; give certificate and key (hotgauge certificates)"
            )
        return self


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
