"""The page without a server, before a gauge that says what a test wants."""

import functools
import struct
import tempfile
from pathlib import Path
from typing import Self

from starlette.testclient import TestClient

from appliance.page.access.logins import Logins
from appliance.page.access.users import Users
from appliance.page.application import Application
from appliance.page.commissioning import Commissioning
from appliance.page.parts import Parts
from appliance.page.previews import Previews
from appliance.page.watch import Watch
from plc.poll import Place, Snapshot
from plc.process_image import decode, encode
from plc.registers import REGISTERS, SET_POINTS
from plc.rows import select
from plc.security.roles import Role

PASSWORD = "a good password"


@functools.cache
def _users() -> bytes:
    """A file of users, one of each role and named like it; made once, since hashing takes long."""
    with tempfile.TemporaryDirectory() as folder:
        users = Users(Path(folder) / "users.json")
        for role in Role:
            users.put(role, role, PASSWORD)
        return users.file.read_bytes()


class FakeWatch(Watch):
    """A watch that reads nothing; `pressed` counts acknowledgements."""

    def __init__(self) -> None:
        self.now_s = 1000.0
        self.pressed = 0
        self.refuses: Exception | None = None
        super().__init__(Place("127.0.0.1", 5020), clock=lambda: self.now_s)

    def acknowledge(self) -> None:
        if self.refuses:
            raise self.refuses
        self.pressed += 1


class Gauge:
    """Everything that a page reads."""

    def __init__(self, folder: Path) -> None:
        self.watch = FakeWatch()
        self.users = Users(folder / "users.json")
        self.users.file.write_bytes(_users())
        self.logins = Logins(12.0, 30.0)
        self.commissioning = Commissioning(folder / "commissioning", folder / "rig.json", None, lambda _: "")
        self.parts = Parts(self.watch, self.users, self.logins, Previews(folder), None, self.commissioning)
        self.say()

    def say(self, **values: float | None) -> None:
        """Have the registers say this."""
        image = encode({"device_state": 0, **values})
        numbers, side_by_side = (struct.unpack(f">{len(one) // 2}H", one) for one in (image.words, image.bars))
        written = dict.fromkeys((row.name for row in select(REGISTERS, "holding", "rw")), None)
        bits = dict.fromkeys((row.name for row in select(REGISTERS, "discrete", "r")), False)
        bars = decode(side_by_side, block="bars")
        set_points = (0,) * len(SET_POINTS)
        self.watch.add(Snapshot(decode(numbers), bits, 1.0, written, numbers, set_points, bars, side_by_side))


class PageClient(TestClient):
    """A browser without scripts."""

    token = ""
    secret = ""

    def logged_in(self, role: Role) -> Self:
        answer = self.post("/login", data={"name": str(role), "password": PASSWORD})
        assert answer.status_code == 303, answer.text
        name = next(name for name in answer.cookies if "hotgauge" in name)
        self.secret = answer.cookies[name]
        self.cookies.clear()
        self.cookies.set(name, self.secret)
        self.token = self.get("/registers").text.split('name="token" value="')[1].split('"')[0]
        return self


def client_of(gauge: Gauge, *, secure: bool = False) -> PageClient:
    scheme = "https" if secure else "http"
    app = Application(gauge.parts, secure=secure).asgi()
    return PageClient(app, base_url=f"{scheme}://127.0.0.1", follow_redirects=False)


def log_in(client: PageClient, role: Role) -> PageClient:
    return client.logged_in(role)
