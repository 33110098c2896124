"""Aravis' fake GigE Vision cameras, as many as there are addresses, in a network of their own.

A camera answers on one address only, so two need two; a network namespace gives this process's children a loopback
device with as many addresses as they like, without rights (unshare(1), network_namespaces(7)).
"""

import json
import os
import subprocess
import sys
from pathlib import Path

NETWORK = 'ip link set lo up mtu {mtu} && ip address add 127.0.0.2/8 dev lo && exec "$@"'


def in_own_network(*words, mtu=65536, timeout=None, **environment):
    """Output of a command that runs in a network with both addresses and nothing else."""
    shell = ["unshare", "--map-root-user", "--net", "sh", "-c", NETWORK.format(mtu=mtu), "sh"]
    done = subprocess.run(
        [*shell, *map(str, words)], stdout=subprocess.PIPE, text=True, check=True, timeout=timeout,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))} | environment,
    )  # fmt: skip
    return done.stdout


def scenario(name, timeout=300, mtu=65536):
    """Result of a scenario of `gige_scenarios.py`."""
    script = Path(__file__).with_name("gige_scenarios.py")
    said = in_own_network(sys.executable, script, name, mtu=mtu, timeout=timeout)
    return json.loads(said.splitlines()[-1])
