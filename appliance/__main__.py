"""`python -m appliance` is `hotgauge`."""

import sys

from appliance.cli.main import main

sys.exit(main())
