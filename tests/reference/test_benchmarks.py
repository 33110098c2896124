"""The benchmarks run, and tell a gauge that has become slower."""

from functools import partial

import pytest
import rivals
from pair import rig_with_marks, stages
from timing import Row, Times

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig
from vision.sizing.gauge import Gauge


@pytest.mark.parametrize(
    "work",
    [
        partial(rivals.gauge, rivals.SMALL),
        partial(rivals.forest, rivals.SMALL),
        partial(rivals.fusion, rivals.SMALL),
        rivals.ingot,
    ],
    ids=["gauge", "forest", "fusion", "ingot"],
)
def test_each_kind_of_work_is_timed_beside_its_rival(work, tmp_path):
    for row in work(tmp_path, 1):
        assert min(row.ratios) > 0, row


def test_each_stage_of_a_pair_is_timed():
    true_rig = default_rig((800, 600))
    scene = Scene(true_rig, seed=1)
    times = stages(Gauge(rig_with_marks(scene, true_rig)), scene.pair(Bar(180.0), 0))
    assert {"find the bar", "still marks", "route T", "route V", "the whole gauge"} <= times.keys()


def test_a_ratio_that_lost_more_than_15_percent_has_slipped():
    row = Row("a pair", "a rival", Times(10.0, 20.0), Times(100.0, 160.0))
    assert row.ratios == (10.0, 8.0)
    assert not row.has_slipped({"a pair": 9.0})
    assert row.has_slipped({"a pair": 10.0})
    assert not row.has_slipped({"another": 100.0})
