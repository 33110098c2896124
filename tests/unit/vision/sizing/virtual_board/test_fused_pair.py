"""The aligned pair: where the right view lands on the left one, and route V on one picture out of two."""

import numpy as np
import pytest
from coded_pictures import CODINGS
from mill_scenes import perfect_rig
from random_forests import random_forest

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.bars.study_scenes import draw
from appliance.simulation.true_rig import default_rig
from appliance.sizing.trust import trust_percent
from vision.alignment.view_alignment import Alignment
from vision.alignment.virtual_boards import VirtualBoards
from vision.edges.names import EDGE_METHODS
from vision.edges.operators import EdgeOptions
from vision.fusion.common_view import common_rectangle
from vision.fusion.methods import METHODS
from vision.fusion.names import FUSIONS
from vision.geometry.homography import transformed
from vision.geometry.turned_region import whole_picture
from vision.reasons import Reason
from vision.sent_picture import SentPicture, sent_picture
from vision.sizing.virtual_board import gauge as gauge_module
from vision.sizing.virtual_board.gauge import VirtualBoardGauge
from vision.sizing.virtual_board.one_camera import OneCameraGauge
from vision.sizing.virtual_board.parameters import Parameters
from vision.sizing.virtual_board.reading import Corrections

DIAMETER_MM = 180.0
ONE_VIEW = Corrections(projective_boards=False, tangent_crossing=False)


@pytest.fixture(scope="module")
def rig():
    return perfect_rig(default_rig())


@pytest.fixture(scope="module")
def pair():
    return Scene(default_rig(), 1).pair(Bar(DIAMETER_MM), 0)


def painted(camera, height_mm, pattern):
    """What a camera sees of a pattern painted on the plane z = height."""
    width, height = camera.image_size
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).reshape(-1, 2).astype(float)
    rays = camera.rays(pixels)
    reach = (height_mm - camera.centre_mm[2]) / rays[:, 2]
    seen = pattern(camera.centre_mm + rays * reach[:, None])
    return np.where(np.isfinite(seen), seen, 0).astype(np.uint8).reshape(height, width)


def waves(points_mm):
    return 127 + 60 * np.sin(points_mm[:, 0] / 40) + 60 * np.sin(points_mm[:, 1] / 55)


@pytest.mark.parametrize("height_mm", [0.0, 137.0])
def test_a_pattern_on_the_plane_coincides_after_alignment_and_not_on_another_plane(rig, height_mm):
    pictures = (painted(camera, height_mm, waves) for camera in (rig.left, rig.right))
    left, right = map(whole_picture, (rig.left, rig.right), pictures)
    alignment = Alignment(rig, VirtualBoards.of_rig(rig), left, right, projective=True)
    rows, columns = (slice(size // 3, 2 * size // 3) for size in left.picture.shape)

    def apart(height):
        aligned = alignment.right_on_left(height).astype(float)
        return np.abs(aligned - left.picture)[rows, columns].mean()

    assert apart(height_mm) < 1.0
    assert apart(height_mm + 40.0) > 10.0


@pytest.mark.parametrize("height_mm", [0.0, 90.0, 200.0])
def test_t_rl_takes_the_right_pixel_of_a_point_on_the_board_to_its_left_pixel(rig, pair, height_mm):
    left, right = map(whole_picture, (rig.left, rig.right), pair)
    alignment = Alignment(rig, VirtualBoards.of_rig(rig), left, right, projective=True)
    points = np.array([[-80.0, -60.0, height_mm], [90.0, 40.0, height_mm], [10.0, 120.0, height_mm]])
    places = [
        camera.undistort(camera.project(points)) @ camera.K[:2, :2].T + camera.K[:2, 2]
        for camera in (rig.left, rig.right)
    ]
    assert transformed(alignment.right_to_left(height_mm), places[1]) == pytest.approx(places[0], abs=0.01)
    assert np.abs(places[0] - places[1]).max() > 5


def test_c_is_the_median_area_of_the_frame_s_boundaries_and_sigma_of_a_frame_the_median_of_its_windows(rig, pair):
    gauge = VirtualBoardGauge(rig, edges="sobel")
    reading = gauge.measure(*pair)
    sent = [SentPicture.of(picture) for picture in pair]
    areas = np.hstack([gauge.view(view, one, gauge.bars(view, one)[0])[1].areas for view, one in enumerate(sent)])
    assert gauge._uncorrupted_area == pytest.approx(np.median(areas), rel=0.05)
    assert reading.weighted_deviation_mm == np.median(reading.window_sigmas_mm[reading.window_kept])
    assert reading.diameter_mm == pytest.approx(reading.window_diameters_mm[reading.window_kept].mean(), abs=1e-9)


def test_q_r_is_judged_within_a_quarter_of_the_region_of_the_board_s_middle(rig, pair):
    left, right = map(whole_picture, (rig.left, rig.right), pair)
    alignment = Alignment(rig, VirtualBoards.of_rig(rig), left, right, projective=True)
    rows = alignment.test_rows(100.0)
    middle = rig.left.undistort(rig.left.project(np.array([[0.0, 0.0, 100.0]])))[0]
    assert np.ptp(rows) == pytest.approx(left.shape[0] / 2, abs=1)
    assert rows.mean() == pytest.approx(rig.left.K[1] @ [*middle, 1.0], abs=3)


def test_one_camera_on_its_board_s_plane_is_off_and_on_the_plane_of_the_edges_it_is_not(rig, pair):
    on_board = OneCameraGauge(rig, corrections=ONE_VIEW).measure(*pair)
    height_mm = VirtualBoardGauge(rig).measure(*pair).plane_height_mm
    lifted = OneCameraGauge(rig, plane_mm=height_mm, corrections=ONE_VIEW).measure(*pair)
    other = OneCameraGauge(rig, "right", height_mm, corrections=ONE_VIEW).measure(*pair)
    for reading in (lifted, other):
        assert DIAMETER_MM < reading.diameter_mm < DIAMETER_MM + 12  # the tangents' width over the axis
        assert on_board.diameter_mm > reading.diameter_mm + 4
    assert all(one.reasons == Reason.UNCERTAINTY_UNKNOWN for one in (on_board, lifted, other))
    with pytest.raises(ValueError, match="side"):
        OneCameraGauge(rig, "middle")


def test_what_only_the_left_camera_sees_is_the_left_picture(rig):
    pictures = np.full((600, 800), 200, dtype=np.uint8), np.full((600, 800), 30, dtype=np.uint8)
    left, right = map(whole_picture, (rig.left, rig.right), pictures)
    aligned = Alignment(rig, VirtualBoards.of_rig(rig), left, right, projective=True).right_on_left(100.0)
    assert set(np.unique(aligned)) >= {30, 200}
    assert aligned[:, 0].max() == 200
    assert np.median(aligned) == 30


@pytest.mark.parametrize("method", METHODS)
def test_route_v_measures_a_clean_bar_on_every_fused_picture_of_a_symmetric_rig(rig, pair, method):
    reading = VirtualBoardGauge(rig, edges="sobel", fusion=method).measure(*pair)
    assert reading.valid
    assert reading.diameter_mm == pytest.approx(DIAMETER_MM, abs=1.0)
    assert reading.reasons == Reason.UNCERTAINTY_UNKNOWN


def test_fused_pictures_of_subsampled_colours_are_measured_in_luma():
    scene = draw("clean", 3)
    gauge = VirtualBoardGauge(perfect_rig(scene.rig, scene.response), edges="sobel", fusion="db4")
    plain = gauge.measure(scene.left, scene.right)
    sent = [CODINGS["jpeg 4:2:0 q90"].sent([picture]) for picture in (scene.left, scene.right)]
    in_luma, in_colours = gauge.measure(*sent), gauge.measure(*(one.shown for one in sent))
    assert in_luma.diameter_mm == pytest.approx(plain.diameter_mm, abs=0.1)
    assert in_colours.diameter_mm < plain.diameter_mm - 0.2


@pytest.mark.parametrize("height_mm", [0.0, 137.0])
def test_parallax_is_how_far_a_point_moves_in_the_left_picture_for_each_millimetre(rig, pair, height_mm):
    left, right = map(whole_picture, (rig.left, rig.right), pair)
    alignment = Alignment(rig, VirtualBoards.of_rig(rig), left, right, projective=True)
    point = np.array([[30.0, -40.0, height_mm]])
    ray = point - rig.right.centre_mm
    on_boards = [point + ray * step / ray[0, 2] for step in (0.0, 1.0, -1.0)]  # what the right camera sees as one point
    here, above, below = (rig.left.undistort(rig.left.project(one))[0] @ rig.left.K[:2, :2].T for one in on_boards)
    seen = rig.right.undistort(rig.right.project(point)) @ rig.right.K[:2, :2].T + rig.right.K[:2, 2]
    pixel = np.append(seen[0], 1.0)
    to_left = alignment.right_to_left(height_mm)
    moved, scale = alignment.parallax(height_mm) @ pixel, (to_left / to_left[2, 2] @ pixel)[2]
    place = here + rig.left.K[:2, 2]
    assert (moved[:2] - place * moved[2]) / scale == pytest.approx((above - below) / 2, rel=0.01, abs=1e-3)


def test_of_views_compressed_differently_the_fused_picture_counts_as_the_coarser(monkeypatch):
    scene = draw("clean", 0)
    rig = perfect_rig(scene.rig, scene.response)
    codings = []

    def sent(luma, coding, shown):
        codings.append(coding)
        return sent_picture(luma, coding, shown)

    monkeypatch.setattr(gauge_module, "sent_picture", sent)
    fine, coarse = (CODINGS[f"jpeg 4:2:0 q{quality}"] for quality in (90, 75))
    VirtualBoardGauge(rig, edges="sobel", fusion="db4").measure(fine.sent([scene.left]), coarse.sent([scene.right]))
    assert {coding.quality for coding in codings} == {75}


CHOICES = [(edges, fusion) for edges in EDGE_METHODS for fusion in FUSIONS]


@pytest.fixture(scope="module")
def aligned(rig, pair):
    gauge = VirtualBoardGauge(rig, edges="sobel")
    gauge.measure(*pair)
    return gauge.last_pair


@pytest.mark.parametrize(("edges", "fusion"), CHOICES)
def test_u_is_stated_where_a_study_holds_it_against_the_truth_and_else_there_is_a_reason_and_no_trust(
    rig, aligned, edges, fusion
):
    """The study is tests/studies/route_v_uncertainty.py, its coverage held in test_stated_uncertainty.py."""
    reading = VirtualBoardGauge(rig, edges=edges, fusion=fusion).read(aligned, Reason.NONE)
    assert reading.valid
    if fusion == "none":
        assert 0 < reading.expanded_uncertainty_mm < 1
        assert reading.reasons == Reason.NONE
        assert trust_percent(reading.size_reading()) > 0
    else:
        assert np.isnan(reading.expanded_uncertainty_mm)
        assert reading.reasons == Reason.UNCERTAINTY_UNKNOWN
        assert trust_percent(reading.size_reading()) == 0.0


@pytest.mark.parametrize(
    "own",
    [
        EdgeOptions(method="canny", canny_high=0.1),
        EdgeOptions(method="canny", canny_kernel="5x5"),
        EdgeOptions(forest=random_forest(seed=5, depth=4, patches=200)),
    ],
    ids=["thresholds", "kernel", "forest"],
)
def test_an_edge_detector_with_numbers_or_a_model_of_one_s_own_has_no_u(rig, aligned, own):
    reading = VirtualBoardGauge(rig, edges=own).read(aligned, Reason.NONE)
    assert reading.reasons == Reason.UNCERTAINTY_UNKNOWN
    assert trust_percent(reading.size_reading()) == 0.0


def test_a_changed_parameter_says_that_its_uncertainty_is_not_known(rig, pair):
    reading = VirtualBoardGauge(rig, edges="sobel", parameters=Parameters(sample_count=5)).measure(*pair)
    assert reading.reasons == Reason.UNCERTAINTY_UNKNOWN
    assert reading.diameter_mm == pytest.approx(DIAMETER_MM, abs=1.0)


def test_both_cameras_see_a_part_of_the_left_view_and_the_rectangle_holds_nothing_else(rig, pair):
    left, right = map(whole_picture, (rig.left, rig.right), pair)
    seen = Alignment(rig, VirtualBoards.of_rig(rig), left, right, projective=True).seen_by_both(100.0)
    rectangle = common_rectangle(seen)
    assert 0.3 < seen.mean() < 0.99
    assert seen[rectangle].all()
    assert seen[rectangle].size > 0.5 * seen.sum()


def test_the_common_rectangle_is_the_largest_one():
    seen = np.zeros((80, 160), bool)
    seen[16:64, 8:72] = seen[40:48, 0:160] = True
    assert common_rectangle(seen) == (slice(16, 64), slice(8, 72))
    assert seen[common_rectangle(~np.ones((80, 160), bool))].size == 0


def test_an_unknown_fusion_is_named(rig):
    with pytest.raises(ValueError, match="fusion: 'both' is none of none, fft, "):
        VirtualBoardGauge(rig, fusion="both")
