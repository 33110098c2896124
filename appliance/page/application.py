"""The page as a web application: routes, log-in and log-out, and what a request must be to be answered."""

import asyncio
import logging
import math
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlencode

from starlette.applications import Starlette
from starlette.datastructures import FormData
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Receive, Scope, Send

from appliance.errors import HotgaugeError
from appliance.page.access.guards import Guards, TooLargeError
from appliance.page.access.logins import Login
from appliance.page.board_pictures import BoardPicturesError
from appliance.page.commissioning import CommissioningError
from appliance.page.parts import Parts
from appliance.page.rendering import VIEWS, language_of, page, render
from appliance.page.texts import LANGUAGES, Texts
from appliance.page.views import cameras, commission, history, line, registers
from plc.client import WriteRefusedError
from plc.poll import PollError
from plc.security.roles import Role

logger = logging.getLogger("hotgauge.page")

_LIVE: dict[str, Callable[[Parts, Texts, Login], dict[str, Any]]] = {
    "line": line.values,
    "cameras": cameras.values,
    "registers": registers.values,
}
"""Views that renew themselves."""

_STEPS = {"capture", "stop", "calibrate", "verify", "confirm"}

COOKIE_AGE_S = 365 * 86400  # of language and light, which tell nobody anything


class _Refused(NamedTuple):
    """Why a request is not answered."""

    response: Response


class PassingFile(FileResponse):
    """A file in a folder of its own, deleted when it was sent, or when the browser has gone before."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the file, then delete its folder."""
        try:
            await super().__call__(scope, receive, send)
        finally:
            await asyncio.to_thread(shutil.rmtree, Path(self.path).parent)


class Application:
    """Everything that the page answers.

    Parameters
    ----------
    parts : Parts
    secure : bool
        Whether it is served by TLS; cookies are then never sent without.
    """

    def __init__(self, parts: Parts, *, secure: bool) -> None:
        self._parts = parts
        self._secure = secure
        self._cookie = "__Host-hotgauge" if secure else "hotgauge"
        self._one_login = asyncio.Lock()  # a hash costs 64 MiB, and attempts are counted one by one

    def asgi(self) -> ASGIApp:
        """The application as a server runs it, with its guards around it."""
        routes = [
            Route("/", self._root),
            Route("/login", self._show_login),
            Route("/login", self._log_in, methods=["POST"]),
            Route("/logout", self._log_out, methods=["POST"]),
            Route("/set", self._set),
            Route("/acknowledge", self._acknowledge, methods=["POST"]),
            Route("/pictures/{station:str}/{number:int}", self._picture),
            Route("/documents/{name:str}", self._document),
            Route("/live/{view:str}", self._live),
            *(Route(f"/{view}", self._show) for view in _LIVE),
            Route("/history", self._history),
            Route("/history/{name:str}", self._history_file),
            Route("/commission", self._commission),
            Route("/commission/{step:str}", self._do_step, methods=["POST"]),
            Mount("/static", StaticFiles(packages=[("appliance.page", "static")])),
        ]
        handlers = {404: self._not_found, HotgaugeError: self._trouble, TooLargeError: _too_large}
        app = Starlette(routes=routes, exception_handlers=handlers)
        return Guards(app, secure=self._secure)

    def _login(self, request: Request, *, acts: bool = True) -> Login | None:
        return self._parts.logins.find(request.cookies.get(self._cookie, ""), acts=acts)

    def _root(self, _: Request) -> Response:
        return RedirectResponse("/line", 303)

    def _not_found(self, request: Request, _: Exception) -> Response:
        login = self._login(request, acts=False)
        heading = Texts(language_of(request))("not_found")
        return page(request, "line", {"template": "message", "heading": heading}, login, status=404)

    def _trouble(self, request: Request, error: Exception) -> Response:
        """Trouble that a person can mend, in its own sentence."""
        login = self._login(request, acts=False)
        return page(request, "line", {"template": "message", "heading": str(error)}, login, status=500)

    def _show(self, request: Request) -> Response:
        login = self._login(request)
        if login is None:
            return RedirectResponse("/login", 303)
        view = request.url.path.removeprefix("/")
        values = _LIVE[view](self._parts, Texts(language_of(request)), login)
        return page(request, view, values, login, live=f"/live/{view}")

    def _live(self, request: Request) -> Response:
        login = self._login(request, acts=False)
        if login is None:
            return PlainTextResponse("not logged in", 401)
        view = request.path_params["view"]
        if view == "commission" and not login.may(Role.ENGINEER):
            return PlainTextResponse("not allowed", 403)
        if view not in _LIVE and view != "commission":
            return PlainTextResponse("no such view", 404)
        texts = Texts(language_of(request))
        values = _LIVE.get(view, commission.live)(self._parts, texts, login)
        return HTMLResponse(render(f"{view}_live.html", texts, values | {"login": login}))

    def _picture(self, request: Request) -> Response:
        if self._login(request, acts=False) is None:
            return PlainTextResponse("not logged in", 401)
        station, number = request.path_params["station"], request.path_params["number"]
        preview = self._parts.previews.newest(station) if station in {"sizing", "ingot"} else None
        if preview is None or number >= len(preview.pictures):
            return PlainTextResponse("no picture", 404)
        return Response(preview.pictures[number], media_type="image/jpeg")

    def _document(self, request: Request) -> Response:
        if self._login(request) is None:
            return RedirectResponse("/login", 303)
        name = request.path_params["name"]
        if name not in registers.DOCUMENTS:
            return PlainTextResponse("no such document", 404)
        headers = {"Content-Disposition": f'attachment; filename="{name}"'}
        return Response(registers.DOCUMENTS[name](), media_type="text/plain; charset=utf-8", headers=headers)

    def _history(self, request: Request) -> Response:
        login = self._login(request)
        if login is None:
            return RedirectResponse("/login", 303)
        texts = Texts(language_of(request))
        return page(request, "history", history.values(self._parts.history, texts, request.query_params), login)

    def _history_file(self, request: Request) -> Response:
        """A table as CSV, or the shift report, made for this request and deleted after it."""
        if self._login(request) is None:
            return RedirectResponse("/login", 303)
        name, folder = request.path_params["name"], self._parts.history
        table = name.removesuffix(".csv")
        if folder is None or (name != "report.html" and table not in history.EXPORTS):
            return PlainTextResponse("no such file", 404)
        period = history.Period.of(request.query_params)
        made = Path(tempfile.mkdtemp())
        try:
            if name == "report.html":
                history.report(folder, period, made / name)
            else:
                history.export(folder, table, period, made / name)
        except BaseException:
            shutil.rmtree(made)
            raise
        return PassingFile(made / name, filename=name)

    def _commission(self, request: Request) -> Response:
        login = self._login(request)
        if login is None:
            return RedirectResponse("/login", 303)
        if not login.may(Role.ENGINEER):
            return self._refuse(request, login, "not_allowed")
        texts = Texts(language_of(request))
        values = commission.values(self._parts, texts, login, request.query_params)
        return page(request, "commission", values, login, live="/live/commission")

    async def _do_step(self, request: Request) -> Response:
        login = await self._allow(request, Role.ENGINEER)
        if isinstance(login, _Refused):
            return login.response
        step = request.path_params["step"]
        if step not in _STEPS:
            return PlainTextResponse("no such step", 404)
        form = await request.form()
        fields = {name: _field(form, name) for name in form}
        logger.info("%s (%s) begins: %s", login.name, login.role, step)
        try:
            await asyncio.to_thread(commission.act, self._parts.commissioning, step, fields, login.name)
        except (CommissioningError, BoardPicturesError) as error:
            return page(request, "commission", {"template": "message", "heading": str(error)}, login, status=409)
        login.said = {"confirm": "confirmed", "stop": "capture_stopped"}.get(step, "step_begun")
        return RedirectResponse(f"/commission?{urlencode({'folder': fields.get('folder', '')})}", 303)

    def _set(self, request: Request) -> Response:
        """Keep language or light of this browser."""
        back = request.query_params.get("back", "")
        answer = RedirectResponse(f"/{back}" if back in {*VIEWS, "login"} else "/line", 303)
        choices = {"language": LANGUAGES, "light": ("day", "night")}
        for name, allowed in choices.items():
            wanted = request.query_params.get(name, "")
            if wanted in allowed:
                answer.set_cookie(name, wanted, COOKIE_AGE_S, secure=self._secure, httponly=True, samesite="strict")
        return answer

    def _show_login(self, request: Request, said: str = "", status: int = 200) -> Response:
        values = {"no_users": not self._parts.users.all()}
        return page(request, "log_in", values | {"template": "login", "said": said}, status=status)

    async def _log_in(self, request: Request) -> Response:
        form = await request.form(max_files=0, max_fields=10)
        name, password = _field(form, "name"), _field(form, "password")
        keys = f"address {request.client.host if request.client else ''}", f"name {name[:60]}"
        texts = Texts(language_of(request))
        async with self._one_login:
            wait_s = self._parts.attempts.wait_s(*keys)
            if wait_s:
                said = texts("too_many_attempts", minutes=math.ceil(wait_s / 60))
                answer = self._show_login(request, said, 429)
                answer.headers["Retry-After"] = str(math.ceil(wait_s))
                return answer
            user = await asyncio.to_thread(self._parts.users.check, name, password)
            if user is None:
                self._parts.attempts.add(*keys)
        if user is None:
            logger.warning("log-in of %.60r from %s refused", name, keys[0])
            return self._show_login(request, texts("wrong_password"), 403)
        self._parts.attempts.forget(keys[1])
        self._parts.logins.end(request.cookies.get(self._cookie, ""))
        logger.info("%s (%s) has logged in from %s", user.name, user.role, keys[0])
        answer = RedirectResponse("/line", 303)
        secret = self._parts.logins.begin(user.name, user.role)
        answer.set_cookie(self._cookie, secret, secure=self._secure, httponly=True, samesite="strict")
        return answer

    async def _log_out(self, request: Request) -> Response:
        allowed = await self._allow(request, Role.VIEWER)
        if isinstance(allowed, _Refused):
            return allowed.response
        self._parts.logins.end(request.cookies.get(self._cookie, ""))
        answer = RedirectResponse("/login", 303)
        answer.delete_cookie(self._cookie, secure=self._secure, httponly=True, samesite="strict")
        return answer

    async def _acknowledge(self, request: Request) -> Response:
        login = await self._allow(request, Role.OPERATOR)
        if isinstance(login, _Refused):
            return login.response
        try:
            await asyncio.to_thread(self._parts.watch.acknowledge)
            login.said = "acknowledged"
            logger.info("alarms acknowledged by %s (%s)", login.name, login.role)
        except WriteRefusedError as error:
            login.said = "acknowledge_refused"
            logger.warning("%s (%s) could not acknowledge: %s", login.name, login.role, error)
        except PollError as error:
            login.said = "acknowledge_lost"
            logger.warning("%s (%s) could not acknowledge: %s", login.name, login.role, error)
        return RedirectResponse("/line", 303)

    async def _allow(self, request: Request, role: Role) -> "Login | _Refused":
        """The log-in that sent a form, if its token is right and its role is enough."""
        login = self._login(request)
        if login is None:
            return _Refused(RedirectResponse("/login", 303))
        form = await request.form(max_files=0, max_fields=100)
        why = "" if _field(form, "token") == login.token else "form_old"
        why = why or ("" if login.may(role) else "not_allowed")
        if not why:
            return login
        return _Refused(self._refuse(request, login, why))

    def _refuse(self, request: Request, login: Login, why: str) -> Response:
        values = {"template": "message", "heading": Texts(language_of(request))(why)}
        return page(request, "line", values, login, status=403)


def _too_large(_request: Request, _error: Exception) -> Response:
    return PlainTextResponse("too large", 413, {"Connection": "close"})


def _field(form: FormData, name: str) -> str:
    value = form.get(name, "")
    return value if isinstance(value, str) else ""
