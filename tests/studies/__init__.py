"""Named studies: long statistics on scenes with known truth, written to docs/studies by `make study`.

A study is a module with `TEXT` (one sentence), `cases() -> list of dict`, `run(case) -> dict` (the same case gives the
same result, on any day) and `summary(rows) -> dict`. Cases and results are JSON. One whose results are times, which
belong to the computer and the day, says `REPEATABLE = False`; its sample is a test of its own. `SAMPLE` is how many of
its cases are tested, where they take long.
"""

import appliance  # noqa: F401  before numpy: it keeps the linear algebra library to one thread
