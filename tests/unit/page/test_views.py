"""Views of the page by themselves, beside what the browser tests show."""

from types import SimpleNamespace

import pytest

from appliance.page.commissioning import CommissioningError
from appliance.page.texts import Texts
from appliance.page.views import cameras, line
from appliance.page.views.commission import act
from appliance.page.views.line import _ADVICE, DECISION_MARKS, _judged
from appliance.page.watch import Watch
from plc.poll import Place

WATCH = SimpleNamespace(wanted=lambda _: None)


@pytest.mark.parametrize(("served", "shown"), [(None, 0), (0, 0), (1, 1), (2, 2), (3, 3)])
def test_without_a_decision_none_is_shown_and_never_in(served, shown):
    snapshot = SimpleNamespace(values=dict.fromkeys(_ADVICE) | {"decision": served})
    judged = _judged(WATCH, snapshot)
    assert (judged["decision"], judged["mark"]) == (shown, DECISION_MARKS[shown])


def test_a_gauge_that_was_never_read_is_shown_as_lost_and_not_as_one_without_alarms():
    parts = SimpleNamespace(watch=Watch(Place("127.0.0.1", 5020)), previews=SimpleNamespace(address=lambda *_: None))
    shown = line.values(parts, Texts("en"), SimpleNamespace(may=lambda _: False))
    assert not shown["gauge"]
    assert (shown["size"]["valid"], shown["health"]["state"], shown["alarms"]) == (False, 4, [])


def test_without_a_gauge_there_is_no_decision_and_nothing_wanted():
    judged = _judged(WATCH, None)
    assert (judged["decision"], judged["mark"], judged["wanted"]) == (0, DECISION_MARKS[0], None)


@pytest.mark.parametrize(
    ("form", "length_mm"),
    [
        ({"what": "boards", "square": "0.5"}, None),
        ({"what": "boards", "square": "-5"}, None),
        ({"what": "boards", "square": "49,8"}, 49.8),
        ({"what": "low", "low": "-5"}, -5.0),
        ({"what": "high", "high": "200"}, 200.0),
    ],
)
def test_a_square_has_a_size_and_a_board_may_lie_below_zero(form, length_mm):
    begun = []
    commissioning = SimpleNamespace(board_pictures=SimpleNamespace(begin=lambda *words: begun.append(words[-1])))
    if length_mm is None:
        with pytest.raises(CommissioningError, match="no length"):
            act(commissioning, "capture", form, "anna")
    else:
        act(commissioning, "capture", form, "anna")
    assert begun == ([] if length_mm is None else [length_mm])


@pytest.mark.parametrize(("rate_hz", "shown"), [(None, []), (12.5, ["12.5 / s"])])
def test_the_rate_of_pictures_is_shown_where_it_is_known(rate_hz, shown):
    preview = SimpleNamespace(rate_hz=rate_hz, figures={"exposed_utc_ms": 0})
    assert [text for _, text in cameras._figures(preview, Texts("en")) if text.endswith("/ s")] == shown
