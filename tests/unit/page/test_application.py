"""The page as a browser asks it: who gets what, and what an attacker gets."""

import asyncio
import contextlib
import dataclasses
import tempfile
from pathlib import Path

import pytest
from page_client import PASSWORD, Gauge, client_of, log_in

from appliance.history import database
from appliance.page.access.attempts import FAILURES_MAX
from appliance.page.access.guards import BODY_MAX_BYTES
from appliance.page.application import PassingFile
from plc.client import WriteRefusedError
from plc.security.roles import Role

VIEWS = ("/line", "/cameras", "/registers", "/history")


@pytest.fixture
def gauge(tmp_path) -> Gauge:
    return Gauge(tmp_path)


@pytest.mark.parametrize("address", [*VIEWS, "/documents/registers.csv", "/history/bars.csv"])
def test_without_a_log_in_there_is_only_the_way_to_it(gauge, address):
    answer = client_of(gauge).get(address)
    assert (answer.status_code, answer.headers["location"]) == (303, "/login")


@pytest.mark.parametrize("address", ["/live/line", "/live/registers", "/pictures/sizing/0"])
def test_without_a_log_in_nothing_renews_itself(gauge, address):
    assert client_of(gauge).get(address).status_code == 401


@pytest.mark.parametrize("address", VIEWS)
@pytest.mark.parametrize("language", ["en", "de"])
def test_every_view_is_shown_in_both_languages(gauge, address, language):
    client = log_in(client_of(gauge), Role.VIEWER)
    answer = client.get(address, headers={"Accept-Language": language})
    assert answer.status_code == 200
    assert f'<html lang="{language}"' in answer.text


def test_the_line_shows_what_the_registers_say(gauge):
    gauge.say(diameter=100.256, expanded_uncertainty=0.1234, validity=1, decision=2)
    text = log_in(client_of(gauge), Role.VIEWER).get("/live/line").text
    assert '<output id="diameter">100.26</output>' in text
    assert "± 0.12 mm" in text
    assert "out of tolerance" in text


def test_bars_side_by_side_are_shown_each_with_its_size_and_what_is_wrong_with_it(gauge):
    bars = {"bars_count": 2, "bar_1_diameter": 100.251, "bar_1_validity": 1, "bar_1_offset": -120.0}
    gauge.say(validity=0, reason_word=4, **bars, bar_2_validity=0, bar_2_reason_word=8)
    text = log_in(client_of(gauge), Role.VIEWER).get("/live/line").text
    assert "<strong>100.25</strong>" in text
    assert "<td>−120</td>" in text
    assert "too few sub-pixel edge points" in text
    assert text.count('<tr><th scope="row">') == 2


def test_a_number_stands_with_the_sign_of_its_language(gauge):
    gauge.say(diameter=100.256, validity=1)
    text = log_in(client_of(gauge), Role.VIEWER).get("/live/line", headers={"Accept-Language": "de-AT"}).text
    assert '<output id="diameter">100,26</output>' in text


def test_no_value_is_shown_as_none_with_its_reason(gauge):
    gauge.say(diameter=None, validity=0, reason_word=1)
    text = log_in(client_of(gauge), Role.VIEWER).get("/live/line").text
    assert '<output id="diameter">–</output>' in text
    assert "no hot bar crosses the measuring region" in text


def test_a_gauge_that_does_not_answer_leaves_no_number_standing(gauge):
    gauge.say(diameter=100.256, validity=1)
    gauge.watch.now_s += 2
    text = log_in(client_of(gauge), Role.VIEWER).get("/live/line").text
    assert '<output id="diameter">–</output>' in text
    assert "No connection to the gauge" in text


def test_the_register_table_has_words_and_value(gauge):
    gauge.say(diameter=100.25)
    text = log_in(client_of(gauge), Role.VIEWER).get("/live/registers").text
    assert '<td class="words" id="words-diameter">42C8 8000</td><td id="value-diameter">100.250 mm</td>' in text
    assert "<td>16</td><td>30017, 40017</td>" in text


def test_every_document_can_be_had(gauge):
    client = log_in(client_of(gauge), Role.VIEWER)
    names = [part.split('"')[0] for part in client.get("/registers").text.split('href="/documents/')[1:]]
    assert len(names) >= 5
    for name in names:
        assert len(client.get(f"/documents/{name}").text) > 1000


def test_an_operator_acknowledges_and_a_viewer_does_not(gauge):
    gauge.say(alarm_word=1)
    for role, pressed in ((Role.VIEWER, 0), (Role.OPERATOR, 1)):
        client = log_in(client_of(gauge), role)
        assert ('action="/acknowledge"' in client.get("/line").text) == bool(pressed)
        answer = client.post("/acknowledge", data={"token": client.token})
        assert answer.status_code == (303 if pressed else 403)
        assert gauge.watch.pressed == pressed


def test_an_acknowledgement_that_the_gauge_refuses_is_said(gauge):
    gauge.watch.refuses = WriteRefusedError("refused")
    client = log_in(client_of(gauge), Role.OPERATOR)
    client.post("/acknowledge", data={"token": client.token})
    assert "The gauge refuses" in client.get("/line").text
    assert "The gauge refuses" not in client.get("/line").text


# what an attacker tries


def test_a_form_of_another_site_is_refused(gauge):
    client = log_in(client_of(gauge), Role.OPERATOR)
    for headers in ({"Origin": "http://evil.example"}, {"Sec-Fetch-Site": "cross-site"}, {"Origin": "null"}):
        assert client.post("/acknowledge", data={"token": client.token}, headers=headers).status_code == 403
    assert gauge.watch.pressed == 0


@pytest.mark.parametrize("token", ["", "guessed", None])
def test_a_form_without_its_token_is_refused(gauge, token):
    client = log_in(client_of(gauge), Role.OPERATOR)
    assert client.post("/acknowledge", data={} if token is None else {"token": token}).status_code == 403
    assert gauge.watch.pressed == 0


def test_a_secret_that_was_there_before_the_log_in_is_worth_nothing_after_it(gauge):
    client = client_of(gauge)
    client.cookies.set("hotgauge", "planted-by-an-attacker")
    log_in(client, Role.OPERATOR)
    assert client.secret != "planted-by-an-attacker"
    other = client_of(gauge)
    other.cookies.set("hotgauge", "planted-by-an-attacker")
    assert other.get("/line").status_code == 303


def test_a_second_log_in_ends_the_first_and_a_log_out_ends_it_on_the_server(gauge):
    client = log_in(client_of(gauge), Role.OPERATOR)
    first = client.secret
    log_in(client, Role.VIEWER)
    client.post("/logout", data={"token": client.token})
    for secret in (first, client.secret):
        other = client_of(gauge)
        other.cookies.set("hotgauge", secret)
        assert other.get("/line").status_code == 303


def test_the_cookie_is_no_script_s_and_no_other_site_s(gauge):
    for secure in (False, True):
        client = client_of(gauge, secure=secure)
        answer = client.post("/login", data={"name": "viewer", "password": PASSWORD})
        cookie = answer.headers["set-cookie"].lower()
        assert "httponly" in cookie
        assert "samesite=strict" in cookie
        assert ("secure" in cookie) == secure
        assert cookie.startswith("__host-hotgauge=" if secure else "hotgauge=")


def test_passwords_are_not_found_by_trying(gauge):
    client = client_of(gauge)
    for _ in range(FAILURES_MAX):
        assert client.post("/login", data={"name": "engineer", "password": "wrong"}).status_code == 403
    answer = client.post("/login", data={"name": "engineer", "password": PASSWORD})
    assert answer.status_code == 429
    assert int(answer.headers["retry-after"]) > 200


def test_a_wrong_name_and_a_wrong_password_are_told_alike(gauge):
    client = client_of(gauge)
    texts = {client.post("/login", data={"name": name, "password": "wrong"}).text for name in ("viewer", "nobody")}
    assert len(texts) == 1


def test_a_body_that_is_too_large_is_refused(gauge):
    client = log_in(client_of(gauge), Role.OPERATOR)
    filler = "x" * BODY_MAX_BYTES
    assert client.post("/acknowledge", data={"token": client.token, "filler": filler}).status_code == 413
    files = {"picture": ("x.png", b"x" * 10)}
    assert client.post("/acknowledge", data={"token": client.token}, files=files).status_code == 400
    assert gauge.watch.pressed == 0


@pytest.mark.parametrize(
    "address",
    [
        "/static/../settings.py",
        "/static/..%2fsettings.py",
        "/static/%2e%2e/%2e%2e/errors.py",
        "/documents/..%2f..%2f..%2fetc%2fpasswd",
        "/pictures/..%2fsizing/0",
        "/history/..%2fhistory.db",
        "/live/..%2fbase",
        "/static//etc/passwd",
    ],
)
def test_no_path_leads_out(gauge, address):
    client = log_in(client_of(gauge), Role.ENGINEER)
    assert client.get(address).status_code == 404


def test_the_way_back_after_a_choice_leads_nowhere_else(gauge):
    client = client_of(gauge)
    for back in ("//evil.example", "https://evil.example", "\\evil.example"):
        assert client.get("/set", params={"language": "de", "back": back}).headers["location"] == "/line"


@pytest.mark.parametrize("address", ["/login", "/line", "/static/page.js", "/nowhere"])
def test_every_answer_binds_the_browser(gauge, address):
    headers = log_in(client_of(gauge), Role.VIEWER).get(address).headers
    assert "default-src 'none'" in headers["content-security-policy"]
    assert "unsafe" not in headers["content-security-policy"]
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["x-frame-options"] == "DENY"
    assert headers["cache-control"] == "no-store"


def test_nothing_of_what_a_person_types_becomes_part_of_the_page(gauge):
    client = log_in(client_of(gauge), Role.VIEWER)
    address = "/history?product=%22%3E%3Cscript%3E&from=%3Cscript%3E&decision=%3C"
    assert "<script>" not in client.get(address).text
    assert client.get("/set?language=%3Cscript%3E&back=line").status_code == 303


def test_no_view_shows_a_secret(gauge):
    client = log_in(client_of(gauge), Role.ENGINEER)
    for view in VIEWS:
        text = client.get(view).text
        assert client.secret not in text
        assert "argon2" not in text


@pytest.fixture
def temporary(tmp_path, monkeypatch) -> Path:
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def test_a_table_that_was_fetched_or_cannot_be_made_leaves_no_file(gauge, tmp_path, temporary):
    gauge.parts = dataclasses.replace(gauge.parts, history=tmp_path)
    with contextlib.closing(database.open_to_write(tmp_path / database.FILE_NAME)):
        pass
    client = log_in(client_of(gauge), Role.VIEWER)
    assert client.get("/history/bars.csv").text.startswith("started_utc")
    (tmp_path / database.FILE_NAME).write_bytes(b"rubbish " * 1000)
    assert client.get("/history/bars.csv").status_code == 500
    assert not list(temporary.iterdir())


def test_a_file_whose_reader_has_gone_is_deleted(temporary):
    file = Path(tempfile.mkdtemp()) / "bars.csv"
    file.write_text("started_utc\n")

    async def says_nothing() -> None:
        await asyncio.Event().wait()

    async def gone(_: object) -> None:
        raise OSError("gone")

    scope = {"type": "http", "method": "GET", "headers": []}
    with pytest.raises(OSError, match="gone"):
        asyncio.run(PassingFile(file, filename=file.name)(scope, says_nothing, gone))
    assert not list(temporary.iterdir())
