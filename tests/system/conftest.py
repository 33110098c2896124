"""The running appliance: its promises are moments, so its tests have the computer for themselves, or nearly so."""

from pathlib import Path

import pytest

FOLDER = Path(__file__).parent


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    for item in items:
        if FOLDER in item.path.parents and not item.get_closest_marker("waiting"):
            item.add_marker(pytest.mark.alone)
