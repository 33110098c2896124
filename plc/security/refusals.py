"""What is logged of clients: each refusal once, and every write within bounds, so that nobody fills the disk."""

import logging
import time
from collections.abc import Callable

REPEATED_AFTER_S = 3600.0
REMEMBERED = 256  # causes and addresses together
LINES_AT_ONCE = 200  # of writes; a mill writes some set points for each product
LINES_PER_S = 1.0

logger = logging.getLogger("hotgauge.clients")


class Refusals:
    """Logs each cause once for each address in an hour, and counts.

    Parameters
    ----------
    clock : callable
        Monotonic time, seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._told_s: dict[tuple[str, str], float] = {}
        self._overflown_s = float("-inf")

    def tell(self, address: str, cause: str) -> None:
        """Log a refusal unless it was logged within the hour.

        Parameters
        ----------
        address : str
        cause : str
            Why, and what to do.
        """
        now_s, key = self._clock(), (address, cause)
        if now_s - self._told_s.get(key, float("-inf")) < REPEATED_AFTER_S:
            return
        if len(self._told_s) >= REMEMBERED and not self._forget(now_s):
            return
        self._told_s[key] = now_s
        logger.warning("client %s refused: %s; more of this within the hour is not logged", address, cause)

    def _forget(self, now_s: float) -> bool:
        """Make room for one more; whether there is any."""
        self._told_s = {key: told_s for key, told_s in self._told_s.items() if now_s - told_s < REPEATED_AFTER_S}
        if len(self._told_s) < REMEMBERED:
            return True
        if now_s - self._overflown_s >= REPEATED_AFTER_S:
            self._overflown_s = now_s
            logger.warning(
                "clients are refused from more addresses than are told apart; those within the hour are not logged"
            )
        return False


class WriteLog:
    """Logs writes one by one; those of a client that writes without end are counted and told together.

    Parameters
    ----------
    clock : callable
        Monotonic time, seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lines = float(LINES_AT_ONCE)
        self._seen_s = clock()
        self._left_out = 0

    def tell(self, client: object, changes: str) -> None:
        """Log one write.

        Parameters
        ----------
        client : object
            Who; its text is logged.
        changes : str
            Old and new values.
        """
        now_s = self._clock()
        self._lines = min(LINES_AT_ONCE, self._lines + (now_s - self._seen_s) * LINES_PER_S)
        self._seen_s = now_s
        if self._lines < 1:
            self._left_out += 1
            return
        self._lines -= 1
        more = f" ({self._left_out} writes before it were too many to log)" if self._left_out else ""
        self._left_out = 0
        logger.info("written by %s: %s%s", client, changes, more)
