"""Options of `measure` for the dissertation's ways: each makes the gauge that it names, or one sentence."""

from functools import partial

import pytest
from random_forests import random_forest

from appliance.cli.main import main, parser
from appliance.sizing.stereo.route_choice import gauge_of
from vision.sizing.gauge import Gauge
from vision.sizing.virtual_board.gauge import VirtualBoardGauge
from vision.sizing.virtual_board.one_camera import OneCameraGauge
from vision.sizing.virtual_board.parameters import PRINTED_PARAMETERS, SERVED_PARAMETERS, Parameters
from vision.sizing.virtual_board.reading import AS_PRINTED, CORRECTED, Corrections


def asked(*words):
    return parser().parse_args(["measure", "line", "--rig", "rig.json", "--output", "x.csv", *words])


def options(*words, method="virtual-board"):
    made = gauge_of(asked("--method", method, *words))
    assert isinstance(made, partial)
    return made.func, made.keywords


def test_without_options_route_v_is_the_served_one():
    kind, given = options()
    assert kind is VirtualBoardGauge
    assert (given["corrections"], given["parameters"]) == (CORRECTED, SERVED_PARAMETERS)
    assert (given["edges"].method, given["edges"].forest, given["fusion"]) == ("forest", None, "none")
    served = gauge_of(asked())
    assert isinstance(served, partial)
    assert served.func is Gauge
    assert served.keywords == {"ovality_mm": None}


def test_as_printed_makes_no_correction_and_takes_the_printed_numbers():
    _, given = options("--as-printed")
    assert (given["corrections"], given["parameters"]) == (AS_PRINTED, PRINTED_PARAMETERS)


def test_corrections_come_back_by_name():
    _, given = options("--as-printed", "--correct", "turned-rows", "--correct", "robust-lines")
    assert given["corrections"] == Corrections(True, True, False, False, False)
    assert given["parameters"] == SERVED_PARAMETERS


def test_every_number_of_the_algorithms_can_be_set():
    words = "--alpha 0.9 --beta 200 --least-neighbours 3 --window-rows 8 --sample-points 5 --sample-count 7 --boards 21"
    _, given = options(*words.split())
    assert given["parameters"] == Parameters(0.9, 200.0, 3, 8, 5, 7, 21)


def test_one_camera_has_a_side_and_a_plane():
    kind, given = options("--side", "right", "--plane-mm", "95", "--as-printed", method="one-camera")
    assert kind is OneCameraGauge
    assert (given["side"], given["plane_mm"], given["corrections"]) == ("right", 95.0, AS_PRINTED)


def test_canny_and_a_trained_forest_are_taken(tmp_path):
    _, given = options("--edges", "canny", "--canny-low", "0.1", "--canny-high", "0.3", "--canny-kernel", "5x5")
    edges = given["edges"]
    assert (edges.method, edges.canny_low, edges.canny_high, edges.canny_kernel) == ("canny", 0.1, 0.3, "5x5")
    forest = random_forest(seed=5, depth=4, patches=200)
    forest.save(tmp_path / "own.npz")
    _, given = options("--edge-model", str(tmp_path / "own.npz"))
    assert given["edges"].forest.trees == forest.trees


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--method virtual-board --correct turned-rows", "--correct: without --as-printed every correction is made"),
        ("--method virtual-board --as-printed --correct robust", "did you mean robust-lines?"),
        ("--method virtual-board --as-printed --correct robust-lines", "robust-lines: they need turned-rows"),
        ("--method virtual-board --beta 300", "--beta is 300.0; it must be from 1 to 255"),
        ("--method virtual-board --sample-points 1", "--sample-points is 1; it must be from 2"),
        ("--method virtual-board --canny-low 0.1", "--canny-low: only canny has it; add --edges canny"),
        ("--method virtual-board --edges canny --canny-low 0.5", "0 < low <= high < 1 wanted"),
        ("--method virtual-board --edges canny --canny-kernel 7x7", "--canny-kernel: there is no 7x7"),
        ("--method virtual-board --edges sobel --edge-model a.npz", "--edge-model: sobel has none"),
        ("--method virtual-board --edge-model nothing.npz", "nothing.npz: cannot be read"),
        ("--method one-camera --fusion fft", "--fusion: only virtual boards have it; add --method virtual-board"),
        ("--method virtual-board --side left", "--side: only one camera has it; add --method one-camera"),
        ("--as-printed", "--as-printed: only virtual boards have it; add --method virtual-board"),
        ("--method one-camera --side middle", "--side: there is no middle; there are left, right"),
    ],
)
def test_what_does_not_belong_together_is_one_sentence(capsys, words, said):
    assert main(["measure", "line", "--rig", "rig.json", "--output", "x.csv", *words.split()]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("words", [["--edges", "sobel"], ["--edge-model", "own.npz"], ["--as-printed"]])
def test_options_that_a_recording_with_its_own_settings_would_ignore_are_refused(words, tmp_path, capsys):
    for name in ("settings.json", "black_box.json"):
        (tmp_path / name).write_text("{}")
    (tmp_path / "own.npz").touch()
    given = ["measure", str(tmp_path), "--method", "virtual-board", "--output", str(tmp_path / "again.csv"), *words]
    assert main(given) == 2
    assert f"{words[0]}: {tmp_path} is measured with its own settings" in capsys.readouterr().err
