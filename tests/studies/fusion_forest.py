"""What fusion is worth to route V with the forest's edges, as `fusion` tells it with Sobel's."""

from studies import fusion

TEXT = "As fusion, with the forest's edges, on fewer seeds."
SEEDS = 20
summary = fusion.summary


def cases():
    return [case for case in fusion.cases() if case["seed"] < SEEDS]


def run(case):
    return fusion.run(case, "forest")
