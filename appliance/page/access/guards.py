"""What guards every request, whatever its view: size, origin, and headers that bind the browser."""

from collections.abc import Mapping
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

BODY_MAX_BYTES = 64 << 10  # of a form; the page is never sent a file
SAFE_METHODS = {"GET", "HEAD"}

HEADERS: Mapping[str, str] = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "connect-src 'self'; form-action 'self'; frame-ancestors 'none'; base-uri 'none'",
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
    "Referrer-Policy": "same-origin",  # with no-referrer a browser says of our own forms that they come from nowhere
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
"""Of every answer: nothing is loaded from elsewhere, no script stands in a page, no other site frames it."""

TRANSPORT_HEADER = ("Strict-Transport-Security", "max-age=31536000")


class TooLargeError(Exception):
    """A request's body is larger than it may be; the application answers it with 413."""


class Guards:
    """The application with its guards around it.

    Parameters
    ----------
    inner : ASGI application
    secure : bool
        Whether it is served by TLS.
    """

    def __init__(self, inner: ASGIApp, *, secure: bool) -> None:
        self._inner = inner
        self._headers = dict(HEADERS) | (dict([TRANSPORT_HEADER]) if secure else {})

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self._inner(scope, receive, send)
            return

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in self._headers.items():
                    headers[name] = value
            await send(message)

        headers = Headers(scope=scope)
        if scope["method"] not in SAFE_METHODS and not _is_own(headers):
            await PlainTextResponse("sent from another site", 403)(scope, receive, send_guarded)
            return
        await self._inner(scope, _limited(receive), send_guarded)


def _is_own(headers: Headers) -> bool:
    """Whether a browser says that a page of ours has sent a form; programs say nothing, and have no log-in to steal."""
    if headers.get("sec-fetch-site", "same-origin") not in {"same-origin", "none"}:
        return False
    origin = headers.get("origin")
    return origin is None or urlsplit(origin).netloc == headers.get("host")


def _limited(receive: Receive) -> Receive:
    left = BODY_MAX_BYTES

    async def receive_limited() -> Message:
        nonlocal left
        message = await receive()
        left -= len(message.get("body", b""))
        if left < 0:
            raise TooLargeError
        return message

    return receive_limited
