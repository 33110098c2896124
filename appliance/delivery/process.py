"""The process that delivers: rows to the broker, figures to Prometheus. The supervisor only writes lines to it.

The supervisor runs it as `python -m appliance.delivery.process DESCRIPTOR`; see `appliance.processes.station_process`.
"""

import threading

from pydantic import TypeAdapter

from appliance.delivery.message import LINES, DeliveryStatus, RowLine
from appliance.delivery.metrics import Metrics
from appliance.delivery.mqtt import MqttSender
from appliance.delivery.settings import DeliverySettings
from appliance.processes.link import StationLink
from appliance.processes.station_process import serve

STATUS_PERIOD_S = 1.0  # the supervisor ends a process that is silent for four


def main() -> None:
    """Deliver until the supervisor closes the link or dies."""
    serve(TypeAdapter(DeliverySettings), run)


def run(settings: DeliverySettings, link: StationLink, closed: threading.Event) -> None:
    """Deliver until `closed`.

    Parameters
    ----------
    settings : DeliverySettings
    link : StationLink
    closed : threading.Event
        Set when the link is closed.
    """
    metrics = Metrics(settings.metrics)
    sender = MqttSender(settings.mqtt) if settings.mqtt.host else None

    def receive(line: bytes) -> None:
        message = LINES.validate_json(line)
        if not isinstance(message, RowLine):
            metrics.update(message)
        elif sender is not None:
            sender.put(message)

    link.on_line = receive
    try:
        while True:
            metrics.open()
            if sender is not None:
                metrics.mqtt_waiting, metrics.mqtt_dropped = sender.waiting, sender.dropped
            link.send(_status(metrics, sender))
            if closed.wait(STATUS_PERIOD_S):
                return
    finally:
        metrics.close()
        if sender is not None:
            sender.close()


def _status(metrics: Metrics, sender: MqttSender | None) -> DeliveryStatus:
    if sender is None:
        return DeliveryStatus(trouble=metrics.trouble, waiting=0, dropped=0)
    trouble = "; ".join(one for one in (metrics.trouble, sender.trouble) if one)
    return DeliveryStatus(trouble=trouble, waiting=sender.waiting, dropped=sender.dropped)


if __name__ == "__main__":
    main()
