"""A small network beside the forest on the terms of the study `edges`: limbs found, false edges, places."""

from functools import cache
from pathlib import Path

from edge_network_on_opencv import EdgeNetwork

from studies import edges
from vision.edges.operators import EdgeMap
from vision.edges.thinning import ridge_normals

TEXT = (
    "Forest and network on coloured pictures of the study `edges` (four of its ten rigs, a frame of each recording), "
    "judged as there: a method's one threshold for all scenes is the highest at which 99 % of all limb rows have an "
    "edge within 3 px. Both learned from rendered scenes alone, the same ones. The network is `edge_network.onnx`."
)
MODEL = Path(__file__).parent / "edge_network.onnx"
METHODS = ("forest", "network")
SEEDS = 4
SAMPLE = 1


def cases():
    def is_drawn(case):
        return case["number"] < (1 if case["scene"] in edges.RECORDED else SEEDS)

    return [case for case in edges.cases() if case["picture"] == "colour" and is_drawn(case)]


def run(case):
    return edges.judged(case, METHODS, found)


def found(image, method):
    if method != "network":
        return edges.edges(image, method)
    strength = network().strength(image)
    return EdgeMap(strength, ridge_normals(strength))


@cache
def network():
    return EdgeNetwork(MODEL)


def summary(rows):
    return edges.of_picture(rows, METHODS)
