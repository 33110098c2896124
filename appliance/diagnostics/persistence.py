"""Whether something lasts, judged from single looks that may miss it or err."""

LONGEST_STEP_S = 1.0  # chosen: between two looks; a longer gap, such as one between two bars, says no more than this


class Persistence:
    """A condition that is seen from time to time, and that lasts when it was there for long enough.

    The time with the condition counts up, the time without it counts down, between 0 and `after_s`: it lasts from
    `after_s` until 0. So one look that errs changes little, and a condition that is there in 80 % of the looks lasts
    after 1.7 times `after_s`; one that is there in half of them never does.

    Parameters
    ----------
    after_s : float
        Seconds.
    """

    def __init__(self, after_s: float) -> None:
        self.lasts = after_s <= 0
        self._after_s = after_s
        self._level_s = 0.0
        self._seen_s: float | None = None

    def add(self, now_s: float, *, there: bool) -> None:
        """Count one look.

        Parameters
        ----------
        now_s : float
            Monotonic time of the look.
        there : bool
            Whether the condition was there.
        """
        step_s = 0.0 if self._seen_s is None else min(max(now_s - self._seen_s, 0.0), LONGEST_STEP_S)
        self._seen_s = now_s
        self._level_s = min(max(self._level_s + (step_s if there else -step_s), 0.0), self._after_s)
        if there and self._level_s >= self._after_s:
            self.lasts = True
        elif not there and self._level_s <= 0:
            self.lasts = False

    def reset(self) -> None:
        """Start again from nothing."""
        self._level_s, self.lasts, self._seen_s = 0.0, False, None
