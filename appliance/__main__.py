"""`python -m appliance` is `hotgauge`."""

import sys

from appliance.cli import main

sys.exit(main())
