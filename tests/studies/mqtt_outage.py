"""Ten minutes without a broker: rows at five times the usual rate, the sender's memory, and what is lost."""

import itertools
import resource
import tempfile
import time
from pathlib import Path

from mosquitto import Broker
from running import free_port

from appliance.delivery.message import RowLine
from appliance.delivery.mqtt import MqttSender
from appliance.delivery.settings import MqttSettings

TEXT = (
    "Ten readings a second, five times what a gauge sends of a bar, are handed to the sender over TLS while Mosquitto "
    "is away for the time given; then it comes back. Readings that never reach Mosquitto's own subscriber, those that "
    "were given up, and how much larger the process has become."
)
REPEATABLE = False  # memory and times depend on the computer
OUTAGE_S = 600.0
RATE_HZ = 10.0


def cases():
    return [{"outage_s": OUTAGE_S}]


def run(case):
    with tempfile.TemporaryDirectory() as folder:
        broker = Broker(Path(folder), free_port())
        broker.start()
        broker.subscribe()
        try:
            return _run(broker, case["outage_s"])
        finally:
            broker.close()


def _run(broker, outage_s):
    files = {"authority": "authority.pem", "certificate": "client-gauge.pem", "key": "client-gauge.key"}
    paths = {name: broker.folder / file for name, file in files.items()}
    sender = MqttSender(MqttSettings(host="127.0.0.1", port=broker.port, **paths))
    sent = _send(sender, 5.0, 0)
    before_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    broker.stop()
    sent = _send(sender, outage_s, sent)
    after_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    waiting = sender.waiting
    begun_s = time.monotonic()
    broker.start()
    broker.wait_for(lambda: sender.waiting == 0, 300)
    caught_up_s = time.monotonic() - begun_s
    broker.wait_for(lambda: len(broker.rows("readings")) >= sent, 30)
    got = [row["sequence"] for row in broker.rows("readings")]
    sender.close()
    return {
        "sent": sent,
        "waited": waiting,
        "lost": len(set(range(sent)) - set(got)),
        "given_up": sender.dropped,
        "out_of_order": sum(later < earlier for earlier, later in itertools.pairwise(got)),
        "grown_mb": round(after_mb - before_mb, 1),
        "caught_up_s": round(caught_up_s, 1),
    }


def _send(sender, seconds, first):
    until_s = time.monotonic() + seconds
    number = first
    while time.monotonic() < until_s:
        values = {"exposed_utc_ms": round(1000 * time.time()), "sequence": number, "diameter_mm": 250.125}
        sender.put(RowLine(table="readings", values=values | {"u_edge_mm": 0.02, "trust": 91.0}))
        number += 1
        time.sleep(1 / RATE_HZ)
    return number


def summary(rows):
    return rows[0]
