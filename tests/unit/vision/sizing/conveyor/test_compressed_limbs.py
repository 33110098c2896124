"""Limbs in compressed pictures: which way they lean changes nothing of the doubt about their place."""

from types import SimpleNamespace

import numpy as np
import pytest

from vision.light import ResponseCurve
from vision.sent_picture import Coding
from vision.sizing.conveyor import gauge as gauge_module
from vision.sizing.conveyor.gauge import ConveyorGauge


@pytest.mark.parametrize("slope", [0.02, -0.02, 0.0])
def test_a_limb_crosses_as_many_columns_whichever_way_it_leans(monkeypatch, slope):
    crossed = []
    monkeypatch.setattr(gauge_module, "compression_shift_px", lambda *_: (0.25, 0.1))
    monkeypatch.setattr(gauge_module, "step_codes", lambda *_: 100.0)
    monkeypatch.setattr(
        gauge_module, "u_place_px", lambda _coding, _step, crossed_px: crossed.append(crossed_px) or 0.0
    )
    limb = SimpleNamespace(
        levels=(np.full(9, 0.1), np.full(9, 0.9)), blur_px=1.0, line=(slope, 100.0), rows=np.arange(50, 151)
    )
    gauge = SimpleNamespace(_decoder=SimpleNamespace(whole=lambda _: None), _response=ResponseCurve(1.0))
    ends = [np.array([[100.0, 5.0]]), np.array([[200.0, 5.0]])]
    moved, u_width_px = ConveyorGauge._uncompressed(gauge, ends, (limb, limb), Coding())
    assert crossed == pytest.approx([100 * abs(slope)] * 2)
    assert [float(end[0, 0]) for end in moved] == [99.75, 200.25], "outwards, by as much as compression moved them in"
    assert u_width_px == pytest.approx(0.2)
