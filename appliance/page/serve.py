"""Runs the page until it is stopped."""

from pathlib import Path

import uvicorn

from appliance.conformity.set_points import SetPoints
from appliance.errors import HotgaugeError
from appliance.page.access.logins import Logins
from appliance.page.access.users import Users
from appliance.page.application import Application
from appliance.page.commissioning import Commissioning
from appliance.page.parts import Parts
from appliance.page.previews import Previews
from appliance.page.settings import PageSettings
from appliance.page.watch import Watch
from plc.poll import Place

CONNECTIONS_MAX = 100  # chosen


class PageError(HotgaugeError):
    """The page cannot be served; the message says what, where and what to do."""


def serve_page(
    settings: PageSettings,
    place: Place,
    own: SetPoints,
    *,
    users: Path,
    previews: Path | None,
    history: Path | None,
    commissioning: Commissioning,
    references: Path | None,
) -> None:
    """Serve the page until SIGINT or SIGTERM.

    Parameters
    ----------
    settings : PageSettings
    place : Place
        The gauge.
    own : SetPoints
        Of the settings.
    users : Path
        File of users.
    previews : Path or None
        Runtime directory of the gauge.
    history : Path or None
        Folder of the history.
    commissioning : Commissioning
    references : Path or None
        Folder of the ingots' references.

    Raises
    ------
    PageError
        The port cannot be had, or certificate and key cannot be used.
    """
    watch = Watch(place, own)
    logins = Logins(settings.login_max_h, settings.idle_max_min)
    parts = Parts(watch, Users(users), logins, Previews(previews), history, commissioning, references)
    secure = settings.certificate is not None
    config = uvicorn.Config(
        Application(parts, secure=secure).asgi(),
        host=settings.host,
        port=settings.port,
        ssl_certfile=settings.certificate,
        ssl_keyfile=settings.key,
        access_log=False,
        log_config=None,
        server_header=False,
        proxy_headers=False,
        lifespan="off",
        ws="none",
        limit_concurrency=CONNECTIONS_MAX,
        timeout_graceful_shutdown=2,
        timeout_keep_alive=10,
    )
    try:
        config.load()
        socket = config.bind_socket()
    except (OSError, SystemExit) as error:
        raise PageError(
            f"page: {settings.host}:{settings.port} or the files of page.certificate cannot be used ({error}); "
            "choose another page.port, or mend the files"
        ) from error
    watch.start()
    try:
        uvicorn.Server(config).run([socket])
    finally:
        commissioning.board_pictures.stop()
        watch.stop()
