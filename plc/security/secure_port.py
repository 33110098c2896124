"""The secure port: its certificate, which is renewed without a restart, and what is wrong with it."""

import asyncio
import ssl
from collections.abc import Callable
from datetime import UTC, datetime, timedelta

from plc.security.identity import CertificateError, Identity, TlsFiles, files_state

RENEWAL_PERIOD_S = 5.0
DUE = timedelta(days=30)


class SecurePort:
    """Modbus/TCP Security on a port of its own.

    Parameters
    ----------
    port : int
        TCP port; 0 takes a free one.
    files : TlsFiles

    Attributes
    ----------
    port : int
        The real one once the server has started.
    trouble : str
        Why the files cannot be used as they are now; empty if they can. Earlier ones serve on; without any, every
        client is turned away.
    """

    def __init__(self, port: int, files: TlsFiles) -> None:
        self.port = port
        self.trouble = ""
        self._files = files
        self._identity: Identity | None = None

    async def load(self) -> None:
        """Read the files; `trouble` says what is wrong with them."""
        try:
            self._identity = await asyncio.to_thread(Identity.load, self._files)
        except CertificateError as error:  # perhaps only one of two files has been replaced yet
            self.trouble = str(error)
        else:
            self.trouble = ""

    @property
    def context(self) -> ssl.SSLContext | None:
        """What the next client meets; None before the files could be used for the first time."""
        return None if self._identity is None else self._identity.context

    def due(self, now: datetime | None = None) -> str:
        """What to say of a certificate that ends within 30 days, or has ended; empty as long as none does.

        Parameters
        ----------
        now : datetime, optional
            Moment to judge at; without: the present.
        """
        if self._identity is None:
            return ""
        left = self._identity.expires - (now or datetime.now(UTC))
        if left > DUE:
            return ""
        day = f"{self._identity.expires:%Y-%m-%d}"
        return (
            f"a certificate of the secure port has expired on {day}"
            if left < timedelta(0)
            else (f"a certificate of the secure port expires on {day}")
        )

    async def keep(self, on_other_authority: Callable[[], None]) -> None:
        """Take new files as they come, until cancelled.

        Parameters
        ----------
        on_other_authority : callable
            Called when other clients are trusted than before.
        """
        while True:
            await asyncio.sleep(RENEWAL_PERIOD_S)
            now = await asyncio.to_thread(files_state, self._files)
            if self.trouble or self._identity is None or now != self._identity.state:
                await self._renew(on_other_authority)

    async def _renew(self, on_other_authority: Callable[[], None]) -> None:
        before = self._identity
        await self.load()
        after = self._identity
        if before is not None and after is not None and before.authority_digest != after.authority_digest:
            on_other_authority()


def handshake_in_words(error: OSError) -> str:
    """Why a client has not come in; its own words are never part of it."""
    if isinstance(error, ssl.SSLCertVerificationError):
        return f"its certificate does not hold ({error.verify_message}); make one with hotgauge certificates"
    if isinstance(error, ssl.SSLError):
        reason = (error.reason or "unknown reason").lower().replace("_", " ")
        return f"no TLS 1.2 or newer with a certificate of our authority ({reason})"
    return "it has not shown a certificate in time"
