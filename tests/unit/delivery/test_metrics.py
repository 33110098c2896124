"""Figures as Prometheus reads them: from the tables, absent where there is no value, each alert fired and silent."""

import contextlib
import json
import subprocess
import urllib.request
from collections.abc import Iterator
from pathlib import Path

from prometheus_client.parser import text_string_to_metric_families
from running import free_port

from appliance.delivery.alert_rules import alert_rules, rules_file
from appliance.delivery.message import FiguresLine
from appliance.delivery.metrics import ALARM_NAME, FAULT_NAME, FIGURES, FIGURES_AGE_MAX_S, Metrics
from appliance.delivery.settings import MetricsSettings
from appliance.diagnostics.alarms import ALARMS
from appliance.diagnostics.fault_table import FAULTS
from plc.registers import REGISTERS


@contextlib.contextmanager
def served(figures: FiguresLine | None) -> Iterator[str]:
    metrics = Metrics(MetricsSettings(port=free_port()))
    metrics.open()
    if figures is not None:
        metrics.update(figures)
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{metrics.port}/metrics", timeout=5) as answer:
            yield answer.read().decode()
    finally:
        metrics.close()


def samples(text: str) -> dict[str, float]:
    found = {}
    for family in text_string_to_metric_families(text):
        for sample in family.samples:
            label = "".join(value for name, value in sample.labels.items() if name != "version")
            found[f"{sample.name}{{{label}}}" if label else sample.name] = sample.value
    return found


def figures(**values) -> FiguresLine:
    return FiguresLine(values=values, faults=("camera_lost",), alarms=("alarm_camera",))


def test_registers_stand_as_figures_with_their_unit_and_counters_as_counters():
    line = figures(diameter=250.25, trust=91, measurement_age=40, running=True, frames_dropped=7, validity=1)
    with served(line) as text:
        found = samples(text)
    assert found["hotgauge_diameter_mm"] == 250.25
    assert found["hotgauge_measurement_age_ms"] == 40
    assert found["hotgauge_trust_percent"] == 91
    assert found["hotgauge_running"] == 1
    assert found["hotgauge_frames_dropped_total"] == 7


def test_a_register_without_a_value_has_no_sample():
    with served(figures(diameter=None, expanded_uncertainty=0.1)) as text:
        found = samples(text)
    assert "hotgauge_diameter_mm" not in found
    assert "hotgauge_expanded_uncertainty_mm" in found


def test_every_fault_and_alarm_is_told_active_or_not():
    with served(figures()) as text:
        found = samples(text)
    assert {name for name in found if name.startswith("hotgauge_fault{")} == {
        f"hotgauge_fault{{{row.name}}}" for row in FAULTS
    }
    assert {name: value for name, value in found.items() if name.startswith("hotgauge_alarm{")} == {
        f"hotgauge_alarm{{{row.name}}}": float(row.name == "alarm_camera") for row in ALARMS
    }


def test_figures_older_than_five_seconds_have_no_sample_and_come_back_with_the_next():
    now_s = [100.0]
    metrics = Metrics(MetricsSettings(), lambda: now_s[0])
    metrics.update(figures(diameter=250.0))

    def told() -> set[str]:
        return {family.name for family in metrics.collect() if family.samples}

    now_s[0] += FIGURES_AGE_MAX_S
    assert {"hotgauge_diameter_mm", FAULT_NAME, ALARM_NAME} <= told()
    now_s[0] += 0.1
    assert told() == {"hotgauge", "hotgauge_mqtt_waiting", "hotgauge_mqtt_dropped", "hotgauge_rows_dropped"}
    metrics.update(figures(diameter=250.1))
    assert "hotgauge_diameter_mm" in told()


def test_rows_that_the_supervisor_gave_up_are_counted():
    with served(figures().model_copy(update={"rows_dropped": 12})) as text:
        assert samples(text)["hotgauge_rows_dropped_total"] == 12


def test_before_the_first_figures_only_the_process_itself_is_told():
    with served(None) as text:
        assert not [name for name in samples(text) if "diameter" in name or "fault" in name]


def test_every_measured_register_is_a_figure_once():
    shown = {row.name for row in REGISTERS if row.block == "measurement" and row.unit in {"mm", "%"} and not row.shows}
    assert shown <= {figure.register for figure in FIGURES}
    assert len({figure.name for figure in FIGURES}) == len(FIGURES)


def test_prometheus_own_checker_finds_nothing_wrong_with_the_figures():
    values = {row.name: 1.0 for row in REGISTERS}
    with served(figures(**values)) as text:
        checked = subprocess.run(
            ["promtool", "check", "metrics"], input=text, text=True, capture_output=True, check=False
        )
    complaints = [line for line in checked.stderr.splitlines() if "abbreviated unit" not in line]  # mm, not metres
    assert complaints == []


def test_a_port_that_is_taken_is_told_with_what_to_do():
    first = Metrics(MetricsSettings(port=free_port()))
    first.open()
    second = Metrics(MetricsSettings(port=first.port))
    second.open()
    assert f"127.0.0.1:{first.port}" in second.trouble
    assert "metrics.port" in second.trouble
    first.close()
    second.open()
    assert second.trouble == ""
    second.close()


def series(rule) -> str:
    return rule.expression.removesuffix(" == 1")


HEARTBEAT = 'hotgauge_heartbeat{job="hotgauge"}'


def unit_tests() -> dict:
    """For promtool: each rule fires on its own series alone, and none on a gauge without trouble."""
    beat = {"series": HEARTBEAT, "values": "0+100x40"}
    up = {"series": 'up{job="hotgauge"}', "values": "1+0x40"}
    told = [rule for rule in alert_rules() if rule.expression.endswith("== 1")]
    quiet = [{"series": series(rule), "values": "0+0x40"} for rule in told]

    def test(firing: str, *changed: dict) -> dict:
        names = {one["series"] for one in changed}
        inputs = [*changed, *(one for one in (beat, up, *quiet) if one["series"] not in names)]
        return {
            "interval": "15s",
            "input_series": inputs,
            "alert_rule_test": [
                {"eval_time": "8m", "alertname": rule.name, "exp_alerts": [fired(rule)] if rule.name == firing else []}
                for rule in alert_rules()
            ],
        }

    def fired(rule) -> dict:
        selector = series(rule)
        labels = {"severity": rule.severity} | ({"job": "hotgauge"} if rule.name == "HotgaugeStandsStill" else {})
        if "{" in selector:
            name, value = selector[selector.index("{") + 1 : selector.index("}")].split("=")
            labels[name] = value.strip('"')
        return {"exp_labels": labels, "exp_annotations": {"summary": rule.text, "description": rule.remedy}}

    cases = [test("nothing")]
    cases += [test(rule.name, {"series": series(rule), "values": "1+0x40"}) for rule in told]
    cases.append(test("HotgaugeStandsStill", {"series": HEARTBEAT, "values": "7+0x40"}))
    cases.append(test("HotgaugeStandsStill", {"series": HEARTBEAT, "values": "0+100x6 stale _x34"}))
    cases.append(test("nothing", {"series": HEARTBEAT, "values": "0 _x3 600 _x3 1200 _x3 1800 _x3 2400 _x3 " * 2}))
    cases.append(test("HotgaugeAway", {"series": 'up{job="hotgauge"}', "values": "0+0x40"}))
    return {"rule_files": ["rules.yml"], "evaluation_interval": "15s", "tests": cases}


def test_each_alert_fires_on_its_own_cause_and_stays_silent_on_all_others(tmp_path: Path):
    (tmp_path / "rules.yml").write_text(rules_file(), encoding="utf-8")
    (tmp_path / "tests.yml").write_text(json.dumps(unit_tests()), encoding="utf-8")  # JSON is YAML
    ran = subprocess.run(
        ["promtool", "test", "rules", "tests.yml"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stdout[-3000:] + ran.stderr[-3000:]


def test_every_alarm_and_every_fault_has_its_alert():
    names = {rule.name for rule in alert_rules()}
    assert len(names) == len(ALARMS) + len(FAULTS) + 2
