"""Alert rules for Prometheus, made from the tables of alarms and faults."""

import json
from typing import NamedTuple

from appliance.delivery.metrics import ALARM_NAME, FAULT_NAME
from appliance.diagnostics.alarms import ALARMS
from appliance.diagnostics.fault_table import FAULTS
from plc.codes import DeviceState

AWAY_FOR = "1m"
STILL_WINDOW = "5m"  # five scrapes at Prometheus's default period of 1 min; a window with one sample has no change
SEVERITIES = {DeviceState.FAILURE: "high", DeviceState.OUT_OF_SPECIFICATION: "medium"}


class AlertRule(NamedTuple):
    """One rule.

    Attributes
    ----------
    name : str
    expression : str
        PromQL; it fires while this has a result.
    hold : str
        Time that it must hold before.
    severity : str
    text, remedy : str
    """

    name: str
    expression: str
    hold: str
    severity: str
    text: str
    remedy: str


def alert_rules() -> list[AlertRule]:
    """A rule for each alarm, for each fault, and for a gauge that says nothing."""
    rules = [
        AlertRule(
            "HotgaugeAway",
            'up{job="hotgauge"} == 0',
            AWAY_FOR,
            "high",
            "the gauge's figures cannot be read",
            "check that the gauge runs and that its network is there",
        ),
        AlertRule(
            "HotgaugeStandsStill",
            f"changes(hotgauge_heartbeat[{STILL_WINDOW}]) == 0 "
            'or (up{job="hotgauge"} == 1 unless on (job, instance) hotgauge_heartbeat)',
            AWAY_FOR,
            "high",
            "the gauge's heartbeat stands still or is missing: it tells no new figures",
            "wait ten seconds; if it comes back, send the log to the maker",
        ),
    ]
    rules += [
        AlertRule(
            f"Hotgauge{_camel(row.name)}",
            f'{ALARM_NAME}{{alarm="{row.name}"}} == 1',
            "0s",
            row.priority,
            row.text,
            row.remedy,
        )
        for row in ALARMS
    ]
    return rules + [
        AlertRule(
            f"HotgaugeFault{_camel(row.name)}",
            f'{FAULT_NAME}{{fault="{row.name}"}} == 1',
            "0s",
            SEVERITIES.get(row.state, "low"),
            row.text,
            row.remedy,
        )
        for row in FAULTS
    ]


def rules_file() -> str:
    """All rules as a file for Prometheus (YAML); texts are quoted as JSON, which is YAML too."""
    lines = [
        "# made by `make tables` from the tables of alarms and faults",
        "groups:",
        "  - name: hotgauge",
        "    rules:",
    ]
    for rule in alert_rules():
        lines += [
            f"      - alert: {rule.name}",
            f"        expr: {rule.expression}",
            f"        for: {rule.hold}",
            f"        labels: {{severity: {rule.severity}}}",
            "        annotations:",
            f"          summary: {json.dumps(rule.text, ensure_ascii=False)}",
            f"          description: {json.dumps(rule.remedy, ensure_ascii=False)}",
        ]
    return "\n".join(lines) + "\n"


def _camel(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("_"))
