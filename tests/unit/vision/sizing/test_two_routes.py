"""Route T is served; route V beside it can only take trust away."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig
from appliance.sizing.trust import trust_percent
from vision.calibration.camera_turn import NO_TURN, CameraTurn
from vision.calibration.still_marks import MarksMotion
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sent_picture import SentPicture
from vision.sizing.gauge import CALIBRATION_DUE_PX, CAMERA_MOVED_PX, Gauge, judged
from vision.sizing.tangent.gauge import TangentGauge
from vision.sizing.virtual_board.reading import VirtualBoardReading

TANGENT = SizeReading(diameter_mm=200.0, expanded_uncertainty_mm=0.12, windows_kept=25, windows_total=25)
BAR = Bar(diameter_mm=150.0, offset_mm=12.0, yaw_deg=0.7)


@pytest.fixture(scope="module")
def pair():
    return Scene(default_rig(), seed=4).pair(BAR, 0)


def virtual_board(diameter_mm, expanded_mm=0.16):
    return VirtualBoardReading(
        diameter_mm=diameter_mm,
        u_edge_mm=expanded_mm / 2,
        u_board_mm=0.0,
        u_light_mm=0.0,
        u_model_mm=0.0,
        plane_height_mm=90.0,
    )


@pytest.mark.parametrize(
    ("apart_mm", "agree"), [(0.0, True), (0.19, True), (-0.19, True), (0.21, False), (-0.21, False)]
)
def test_routes_that_differ_by_more_than_both_allow_halve_the_trust(apart_mm, agree):
    reading = judged(TANGENT, virtual_board(200.0 + apart_mm))  # sqrt(0.12^2 + 0.16^2) = 0.20
    assert (Reason.ROUTES_DISAGREE not in reading.reasons) == agree
    assert trust_percent(reading) == (100.0 if agree else 50.0)
    assert reading.valid
    assert reading.diameter_mm == 200.0
    assert reading.diameter_virtual_board_mm == 200.0 + apart_mm
    assert reading.plane_height_mm == 90.0


def test_a_route_without_a_value_judges_nothing():
    reading = judged(TANGENT, VirtualBoardReading(reasons=Reason.NOT_ALIGNED))
    assert reading.reasons == Reason.NONE
    assert math.isnan(reading.diameter_virtual_board_mm)


def test_route_v_alone_is_no_value():
    reading = judged(SizeReading(reasons=Reason.FIT_FAILED), virtual_board(200.0))
    assert not reading.valid
    assert math.isnan(reading.diameter_mm)


def test_both_routes_measure_a_pair_and_agree(pair):
    reading = Gauge(perfect_rig_with_boards()).measure(*pair)
    assert reading.reasons == Reason.NONE
    assert reading.diameter_mm == pytest.approx(150.0, abs=0.1)
    assert reading.diameter_virtual_board_mm == pytest.approx(150.0, abs=0.5)
    assert reading.plane_height_mm > 0


def perfect_rig_with_boards(marks=None):
    true_rig = default_rig()
    rig = perfect_rig(true_rig)
    flat = np.array([(x, y, 0.0) for y in (75.0, 25.0, -25.0, -75.0) for x in range(-150, 151, 50)])
    corners = {
        f"{side}_{name}": camera.project(flat + np.array([0.0, 0.0, height_mm]))
        for side, camera in (("left", rig.left), ("right", rig.right))
        for name, height_mm in (("low", rig.low_mm), ("high", rig.high_mm))
    }
    return replace(rig, boards=corners, **({"marks": marks} if marks else {}))


class Moved:
    """Marks that have all moved by as much as one wants."""

    def __init__(self, distance_px):
        self.distance_px = distance_px

    def motion(self, _):
        place_px = np.array([(x, y) for x in (100.0, 400.0, 700.0) for y in (100.0, 300.0, 500.0)])
        return MarksMotion(
            self.distance_px, place_px, np.tile(np.eye(2), (9, 1, 1)), np.tile([0.0, self.distance_px], (9, 1))
        )


@pytest.mark.parametrize(
    ("distance_px", "reason"),
    [
        (math.nan, Reason.NONE),
        (CALIBRATION_DUE_PX - 0.01, Reason.NONE),
        (CALIBRATION_DUE_PX + 0.01, Reason.CALIBRATION_DUE),
        (CAMERA_MOVED_PX + 0.01, Reason.CAMERA_MOVED),
    ],
)
def test_a_camera_that_moved_is_told_and_far_off_it_serves_nothing(pair, distance_px, reason):
    reading = Gauge(perfect_rig_with_boards((Moved(0.0), Moved(distance_px)))).measure(*pair)
    assert reading.reasons == reason
    assert reading.valid != (reason is Reason.CAMERA_MOVED)


def test_a_camera_that_moved_widens_the_uncertainty(pair):
    gauge = TangentGauge(perfect_rig_with_boards())
    pictures = [SentPicture.of(picture) for picture in pair]
    outlines = gauge.find(*pictures)
    # a turn of nothing that is known to no better than one pixel about any axis
    turns = [(NO_TURN, NO_TURN), (NO_TURN, CameraTurn(np.zeros(3), np.eye(3) / gauge.rig.right.K[0, 0] ** 2))]
    still, turned = (gauge.measure_bar(*pictures, outlines, both) for both in turns)
    assert still.u_calibration_mm == 0.0
    # one pixel is 1.5 mm at the bar; with a base of half the distance it lifts the bar by about 3 mm of 3 m
    assert turned.u_calibration_mm == pytest.approx(150.0 * 3 / 3000, rel=0.5)


def test_a_bar_that_seems_to_float_is_known_less_well(pair):
    turn = cv2.Rodrigues(np.radians([0.0, 0.08, 0.0]))[0]
    rig = perfect_rig(default_rig())
    moved = replace(rig, right=replace(rig.right, R=turn @ rig.right.R, t=turn @ rig.right.t))
    reading = TangentGauge(moved).measure(*pair)
    assert abs(reading.axis_height_mm - 75.0) > 3.0
    assert 0.1 < abs(reading.diameter_mm - 150.0) <= reading.expanded_uncertainty_mm


def test_an_ovality_that_the_product_may_have_is_a_part_of_the_uncertainty(pair):
    reading = TangentGauge(perfect_rig(default_rig()), ovality_mm=0.6).measure(*pair)
    # both views see widths, not the height: of a section whose widths differ by 0.6 mm they miss most
    assert 0.6 * 0.6 / (2 * math.sqrt(3)) < reading.u_shape_mm < 0.6 / (2 * math.sqrt(3))
    assert reading.expanded_uncertainty_mm > 2 * reading.u_shape_mm


def test_a_proof_that_both_cameras_exposed_together_leaves_no_doubt_of_a_late_one(pair):
    gauge = Gauge(perfect_rig_with_boards((Moved(0.0), Moved(0.0))))
    unknown, proved = (gauge.measure_bars(*pair, synchronous=known)[0] for known in (False, True))
    assert unknown.u_motion_mm > 0 == proved.u_motion_mm
    assert proved.u_model_mm < unknown.u_model_mm
    unseen = Gauge(perfect_rig_with_boards()).measure_bars(*pair, synchronous=True)[0]
    assert unseen.u_motion_mm == unknown.u_motion_mm  # without still marks a camera may have turned instead
