"""Lays out what a view shows: templates, and what every page has in common."""

import functools
from typing import Any

import jinja2
from starlette.requests import Request
from starlette.responses import HTMLResponse

from appliance.page.access.logins import Login
from appliance.page.texts import LANGUAGES, Language, Texts
from plc.security.roles import Role

VIEWS = ("line", "cameras", "registers", "history", "commission")
_NEEDS = {"commission": Role.ENGINEER}


@functools.cache
def _environment() -> jinja2.Environment:
    return jinja2.Environment(
        autoescape=True,
        loader=jinja2.PackageLoader("appliance.page"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def language_of(request: Request) -> Language:
    """Language that was chosen, else the first of the browser's that there is, else English."""
    accepted = request.headers.get("accept-language", "").split(",")
    wanted = [request.cookies.get("language", ""), *(one.strip()[:2].lower() for one in accepted)]
    found: list[Language] = [language for one in wanted for language in LANGUAGES if language == one]
    return found[0] if found else "en"


def render(template: str, texts: Texts, values: dict[str, Any]) -> str:
    """Text of a template.

    Parameters
    ----------
    template : str
        Name of its file.
    texts : Texts
    values : dict
        What it names.
    """
    return _environment().get_template(template).render(values | {"texts": texts})


def page(
    request: Request,
    view: str,
    values: dict[str, Any],
    login: Login | None = None,
    *,
    status: int = 200,
    live: str = "",
) -> HTMLResponse:
    """A whole page.

    Parameters
    ----------
    request : Request
    view : str
        Key of its title; the template of its name lays it out.
    values : dict
        What the template names.
    login : Login or None
    status : int
        Of HTTP.
    live : str
        Address of the part that renews itself; empty if there is none.
    """
    texts = Texts(language_of(request))
    said = "" if login is None or not login.said else texts(login.said)
    if login is not None:
        login.said = ""
    common = {
        "view": view,
        "views": [name for name in VIEWS if login is not None and login.may(_NEEDS.get(name, Role.VIEWER))],
        "login": login,
        "live": live,
        "said": said,
        "light": "night" if request.cookies.get("light") == "night" else "day",
    }
    return HTMLResponse(render(f"{values.get('template', view)}.html", texts, common | values), status)
