"""Bars side by side on the simulated mill: each is measured, none is invented, none that is hidden has a value."""

import math
from dataclasses import replace

import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.simulation.bars.real_line import Line, several_bars
from appliance.simulation.true_rig import default_rig
from vision.geometry.measuring_plane import pixel_size_mm
from vision.readings import SizeReading, of_all_bars
from vision.reasons import Reason
from vision.sent_picture import SentPicture
from vision.sizing.gauge import Gauge
from vision.sizing.region_grid import Outline
from vision.sizing.tangent.bar_pairs import crowded
from vision.sizing.tangent.gauge import TangentGauge

RIG = default_rig()


def line_of(offsets_mm, diameter_mm=80.0):
    line = several_bars(4001, len(offsets_mm))
    bars = [
        replace(bar, diameter_mm=diameter_mm + 5 * place, offset_mm=offset_mm, yaw_deg=0.5)
        for place, (bar, offset_mm) in enumerate(zip(line.setup.bars, offsets_mm, strict=True))
    ]
    return Line(replace(line.setup, rig=RIG, bars=tuple(bars)))


def readings_of(line):
    rig = perfect_rig(RIG, line.setup.sensor.response)
    gauge = object.__new__(Gauge)  # route V needs boards, and does not measure several bars
    gauge._rig, gauge._tangent = rig, TangentGauge(rig, 0.0)
    pictures = [SentPicture.of(picture) for picture in next(line.pairs(1))]
    outlines = gauge._tangent.outlines(*pictures)
    return gauge._side_by_side(outlines, lambda pair: gauge._tangent.measure_bar(*pictures, pair))


@pytest.mark.parametrize("offsets_mm", [(-90.0, 60.0), (-150.0, -10.0, 140.0)])
def test_each_bar_is_measured_from_smaller_x(offsets_mm):
    line = line_of(offsets_mm)
    readings = readings_of(line)
    assert [reading.diameter_mm for reading in readings] == pytest.approx(
        [bar.diameter_mm for bar in line.setup.bars], abs=0.15
    )
    assert [reading.offset_mm for reading in readings] == pytest.approx(offsets_mm, abs=1.0)


def test_bars_that_touch_in_a_view_have_no_value():
    readings = readings_of(line_of((-60.0, 29.0)))
    assert not any(reading.valid for reading in readings)
    why = Reason.EDGE_NOT_FOUND | Reason.ONE_CAMERA | Reason.SEVERAL_BARS
    assert all(reading.reasons & why for reading in readings)


@pytest.mark.parametrize(("gap_px", "near"), [(8, True), (9, False)])
def test_bars_just_8_px_apart_are_near_however_the_gap_is_rounded(gap_px, near):
    rig = perfect_rig(RIG)
    for place_px in range(-40, 40):
        views = []
        for camera in (rig.left, rig.right):
            limbs_px = np.array([-60, 0, gap_px, 70]) + place_px
            x_mm = pixel_size_mm(camera) * limbs_px
            views.append([Outline(*(np.array([0.0, x]) for x in pair)) for pair in (x_mm[:2], x_mm[2:])])
        assert [len(view) for view in crowded(rig, tuple(views))] == ([2, 2] if near else [0, 0])


def test_a_bar_of_which_a_neighbour_hides_a_limb_has_no_value():
    line = line_of((-90.0, 60.0))
    seen, hidden = SizeReading(diameter_mm=80.0), SizeReading(diameter_mm=85.0, reasons=Reason.LIMB_HIDDEN)
    gauge = object.__new__(Gauge)
    gauge._rig, gauge._tangent = perfect_rig(RIG), TangentGauge(perfect_rig(RIG), 0.0)
    outlines = gauge._tangent.outlines(*(SentPicture.of(picture) for picture in next(line.pairs(1))))
    first, second = gauge._side_by_side(outlines, lambda pair: seen if pair[0] is outlines[0][0] else hidden)
    assert first == seen
    assert not second.valid
    assert second.reasons == Reason.LIMB_HIDDEN | Reason.EDGE_NOT_FOUND


def test_of_several_bars_the_frame_says_what_cameras_and_light_are_like():
    due, moved = Reason.CALIBRATION_DUE, {"marks_moved_px": 0.7}
    readings = (
        SizeReading(diameter_mm=80.0, reasons=due | Reason.SHIMMER, clipped_share=0.05, limb_light=0.7, **moved),
        SizeReading(diameter_mm=90.0, reasons=due, clipped_share=0.4, limb_light=0.2, **moved),
        SizeReading(reasons=due | Reason.ONE_CAMERA, **moved),
    )
    frame = of_all_bars(readings)
    assert frame.reasons == Reason.SEVERAL_BARS | due
    assert (frame.clipped_share, frame.limb_light, frame.marks_moved_px) == (0.4, 0.2, 0.7)
    assert math.isnan(frame.diameter_mm)
    assert of_all_bars(readings[:1]) is readings[0]


def test_of_bars_without_light_or_marks_the_frame_says_nothing():
    frame = of_all_bars((SizeReading(reasons=Reason.EDGE_NOT_FOUND), SizeReading(reasons=Reason.ONE_CAMERA)))
    assert frame.reasons == Reason.SEVERAL_BARS
    assert all(math.isnan(value) for value in (frame.clipped_share, frame.limb_light, frame.marks_moved_px))
