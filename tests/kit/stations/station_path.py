"""Where a station process that a test starts finds the stations of this folder and the product."""

import os
from pathlib import Path

STATION_PATH = os.pathsep.join([str(Path(__file__).parent), str(Path(__file__).parents[3])])  # for PYTHONPATH
