"""The examples in the docstrings of vision and of the register map run and print what they say."""

import doctest
import importlib

import pytest

MODULES = (
    "plc.process_image", "plc.registers", "vision.readings", "vision.sizing.gauge", "vision.fusion.methods",
    "vision.edges.operators",
)  # fmt: skip


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_a_module_print_what_they_say(name):
    result = doctest.testmod(importlib.import_module(name))
    assert result.attempted > 0, "no example is there to be run"
    assert result.failed == 0
