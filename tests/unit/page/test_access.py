"""Users, log-ins and attempts."""

import json
import stat

import pytest

from appliance.page.access.attempts import FAILURES_MAX, WINDOW_S, Attempts
from appliance.page.access.logins import LOGINS_MAX, Logins
from appliance.page.access.users import Users, UsersError
from plc.security.roles import Role


class Clock:
    def __init__(self) -> None:
        self.now_s = 1000.0

    def __call__(self) -> float:
        return self.now_s


def test_a_user_logs_in_with_the_password_and_no_other(tmp_path):
    users = Users(tmp_path / "users.json")
    users.put("anna", Role.OPERATOR, "correct horse")
    assert users.check("anna", "correct horse").role is Role.OPERATOR
    assert users.check("anna", "correct horsf") is None
    assert users.check("berta", "correct horse") is None
    assert users.check("anna", "") is None


def test_the_file_holds_no_password_and_is_read_by_its_owner_alone(tmp_path):
    file = tmp_path / "deep" / "users.json"
    Users(file).put("anna", Role.VIEWER, "correct horse")
    assert "correct horse" not in file.read_text()
    assert json.loads(file.read_text())[0]["password_hash"].startswith("$argon2id$")
    assert stat.S_IMODE(file.stat().st_mode) == 0o600


def test_a_user_can_be_changed_and_taken_out(tmp_path):
    users = Users(tmp_path / "users.json")
    users.put("anna", Role.VIEWER, "correct horse")
    users.put("anna", Role.ENGINEER, "another horse")
    assert [user.role for user in users.all()] == [Role.ENGINEER]
    assert users.check("anna", "correct horse") is None
    users.remove("anna")
    assert users.all() == []
    with pytest.raises(UsersError, match="none of this name"):
        users.remove("anna")


@pytest.mark.parametrize(("name", "password"), [("", "correct horse"), ("a\nb", "correct horse"), ("anna", "short")])
def test_an_impossible_user_is_refused(tmp_path, name, password):
    with pytest.raises(UsersError):
        Users(tmp_path / "users.json").put(name, Role.VIEWER, password)


def test_a_damaged_file_of_users_lets_nobody_in_and_says_so(tmp_path):
    file = tmp_path / "users.json"
    file.write_text('[{"name": "anna"}]')
    with pytest.raises(UsersError, match="no file of users"):
        Users(file).check("anna", "")


def test_a_log_in_ends_after_its_time_whoever_it_is():
    clock = Clock()
    logins = Logins(1.0, 30.0, clock)
    secret = logins.begin("anna", Role.VIEWER)
    clock.now_s += 3599
    assert logins.find(secret, acts=True) is not None
    clock.now_s += 2
    assert logins.find(secret, acts=True) is None


def test_an_operator_who_does_nothing_is_logged_out_and_a_view_that_renews_itself_is_no_click():
    clock = Clock()
    logins = Logins(12.0, 30.0, clock)
    operator, viewer = logins.begin("anna", Role.OPERATOR), logins.begin("wall", Role.VIEWER)
    for _ in range(31):
        clock.now_s += 60
        logins.find(operator, acts=False)
    assert logins.find(operator, acts=True) is None
    assert logins.find(viewer, acts=False) is not None


def test_log_ins_are_bounded():
    logins = Logins(12.0, 30.0, Clock())
    first = logins.begin("anna", Role.VIEWER)
    others = [logins.begin("anna", Role.VIEWER) for _ in range(LOGINS_MAX)]
    assert logins.find(first, acts=False) is None
    assert logins.find(others[-1], acts=False) is not None


@pytest.mark.parametrize(
    ("role", "may"), [(Role.VIEWER, (1, 0, 0)), (Role.OPERATOR, (1, 1, 0)), (Role.ENGINEER, (1, 1, 1))]
)
def test_each_role_may_what_those_below_it_may(role, may):
    logins = Logins(12.0, 30.0)
    login = logins.find(logins.begin("anna", role), acts=False)
    assert tuple(login.may(needed) for needed in Role) == may


def test_attempts_are_refused_after_five_failures_until_the_first_is_five_minutes_old():
    clock = Clock()
    attempts = Attempts(clock)
    for _ in range(FAILURES_MAX):
        assert attempts.wait_s("address a", "name anna") == 0
        attempts.add("address a", "name anna")
        clock.now_s += 10
    assert attempts.wait_s("address b", "name anna") == pytest.approx(WINDOW_S - 50)
    assert attempts.wait_s("address a", "name berta") > 0
    assert attempts.wait_s("address b", "name berta") == 0
    clock.now_s += WINDOW_S - 49
    assert attempts.wait_s("address a", "name anna") == 0
