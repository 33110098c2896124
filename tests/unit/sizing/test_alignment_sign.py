"""The sign of the alignment quality in the registers."""

import pytest
from messages import reading

from appliance.sizing.published import PUBLISHED


@pytest.mark.parametrize(
    ("quality", "served"),
    [(-100.0, 100.0), (100.0, 100.0), (-99.2, 99.2), (-98.9, -98.9), (98.9, 98.9), (-40.0, -40.0), (None, None)],
)
def test_at_a_match_the_sign_is_always_the_same_and_elsewhere_it_says_where_the_board_lies(quality, served):
    assert PUBLISHED["alignment_quality"](reading(alignment_quality=quality).reading) == served
