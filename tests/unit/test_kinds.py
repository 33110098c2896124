"""Every row of the tables of kinds gives all that its table promises, and the supervisor pays for none of them."""

import importlib.util
import inspect
import subprocess
import sys
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from appliance.cameras.kinds import ConveyorCamera, IngotCamera, StereoCamera
from appliance.cameras.section import PairCamera, PictureCamera
from appliance.cameras.source import CameraError
from appliance.cli.main import COMMANDS, parser
from appliance.cli.pictures.measure import ROOM_BY_METHOD, ROOMS
from appliance.diagnostics.fault_table import FAULTS
from appliance.ingot.reader_setup import load_view
from appliance.ingot.settings import IngotSettings
from appliance.sizing.conveyor.settings import ConveyorLine, ConveyorSettings
from appliance.sizing.measuring import Measuring
from appliance.sizing.method import ScaleError, SizingMethod
from appliance.sizing.settings import Sizing
from vision.ingot.classifiers.classifier import Face, FaceClassifier
from vision.ingot.classifiers.names import ClassifierName
from vision.ingot.classifiers.similarity import as_reference, similarity
from vision.ingot.classifiers.table import CLASSIFIERS

REQUIRED = {
    "path": Path("folder"), "left": "/dev/null", "right": "/dev/null", "address": "/dev/null", "serial": "1",
    "conveyor": ConveyorLine(barrier_mm=500),
}  # fmt: skip


def rows(union) -> tuple[type, ...]:
    """Classes of an annotated union, however often it is annotated."""
    inner = get_args(union)[0]
    return rows(inner) if hasattr(inner, "__metadata__") else get_args(inner)


def made(kind):
    """Settings of a kind with its own name and what it requires."""
    name = "method" if issubclass(kind, SizingMethod) else "kind"
    required = {key: REQUIRED[key] for key, field in kind.model_fields.items() if field.is_required() and key != name}
    return kind.model_validate(required | {name: get_args(kind.model_fields[name].annotation)[0]})


PAIRS = rows(StereoCamera)
PICTURES = tuple(dict.fromkeys(rows(IngotCamera) + rows(ConveyorCamera)))
METHODS = rows(Sizing)


@pytest.mark.parametrize("kind", PAIRS + PICTURES)
def test_a_camera_kind_says_itself_in_words_and_makes_a_source(kind):
    assert issubclass(kind, PairCamera if kind in PAIRS else PictureCamera)
    assert not inspect.isabstract(kind)
    camera = made(kind)
    assert camera.in_words
    if not getattr(camera, "is_on", True):
        with pytest.raises(CameraError, match="give a camera"):
            camera.make_source()
        return
    if camera.kind == "genicam" and importlib.util.find_spec("gi") is None:  # built from source, not for every test
        with pytest.raises(CameraError, match=r"pip install 'PyGObject"):
            camera.make_source(*[5000.0] * (kind in PAIRS))
        return
    source = camera.make_source(5000.0) if kind in PAIRS else camera.make_source()
    assert isinstance(source.simulated, bool)
    assert all(callable(getattr(source, name)) for name in ("__enter__", "__exit__", "next"))


def test_no_two_camera_kinds_are_said_in_the_same_words():
    for kinds in (PAIRS, rows(IngotCamera), rows(ConveyorCamera)):
        words = [made(kind).in_words for kind in kinds]
        assert len(set(words)) == len(words)


@pytest.mark.parametrize("kind", [kind for kind in PAIRS + PICTURES if kind.__module__.endswith("oak.settings")])
def test_an_oak_camera_without_its_library_says_how_to_install_it(kind, monkeypatch):
    monkeypatch.setitem(sys.modules, "depthai", None)
    monkeypatch.delitem(sys.modules, "appliance.cameras.oak.source", raising=False)
    with pytest.raises(CameraError, match=r"pip install depthai"):
        made(kind).make_source(5000.0) if kind in PAIRS else made(kind).make_source()


@pytest.mark.parametrize("kind", PAIRS)
def test_only_the_simulated_mill_has_a_rig_without_a_file(kind):
    assert (made(kind).own_rig() is not None) == (made(kind).kind == "mill")


def test_only_the_simulated_ingot_line_has_references_without_a_folder():
    assert [kind for kind in PICTURES if made(kind).own_ingot_view() is not None] == [
        kind for kind in rows(IngotCamera) if made(kind).kind == "mill"
    ]
    view = IngotSettings(camera={"kind": "mill", "seed": 3}).camera.own_ingot_view()()
    assert view.references.top.shape == view.references.bottom.shape
    assert not np.array_equal(view.references.top, view.references.bottom)
    assert view.crop.width > view.centroid.width > 0


@pytest.mark.parametrize("method", METHODS)
def test_a_sizing_method_has_all_parts_and_measures_a_recording_where_its_camera_was(method):
    assert issubclass(method, SizingMethod)
    assert not inspect.isabstract(method)
    rig = None if method is ConveyorSettings else Path("rig.json")
    replayed = made(method).with_recording(Path("elsewhere"), rig)
    assert replayed.camera.path == Path("elsewhere")
    assert type(replayed).model_validate_json(replayed.model_dump_json()) == replayed
    assert type(replayed.make_source()).__module__.startswith("appliance.cameras.recording")
    assert replayed.check_scale().verdict == "BAD"


def test_what_makes_millimetres_unusable_is_a_fault_of_the_table():
    names = {row.name for row in FAULTS}
    for method in METHODS:
        made(method).check_scale()  # loads the room and its error
    own = {error.fault for error in ScaleError.__subclasses__() if "fault" in vars(error)}
    assert own
    assert own | {made(method).scale_fault for method in METHODS} <= names  # an adjustment's fault is its method's


def test_every_sizing_method_measures_recordings_too():
    rooms = {method.__module__.rpartition(".")[0] for method in METHODS}
    assert {type(room).__module__.rpartition(".")[0] for room in ROOMS} == rooms
    assert set(ROOM_BY_METHOD) >= {made(method).method for method in METHODS}


@pytest.mark.parametrize("room", ROOMS, ids=lambda room: room.names[0])
def test_a_room_that_measures_names_options_that_the_command_has(room):
    assert isinstance(room, Measuring)
    given = parser().parse_args(["measure", "x", "--output", "y", "--method", room.names[0]])
    assert set(room.options) <= set(vars(given))


def test_the_names_of_the_classifiers_are_those_of_their_table():
    assert get_args(ClassifierName) == tuple(CLASSIFIERS)
    assert get_args(IngotSettings.model_fields["classifier"].annotation) == tuple(CLASSIFIERS)


@pytest.mark.parametrize("name", CLASSIFIERS)
def test_a_classifier_calls_the_top_reference_a_top_and_the_bottom_reference_a_bottom(name, recordings):
    assert issubclass(CLASSIFIERS[name], FaceClassifier)
    assert not inspect.isabstract(CLASSIFIERS[name])
    view = load_view(recordings / "ingot_line").references
    top, bottom = as_reference(view.top), as_reference(view.bottom)
    classifier = CLASSIFIERS[name](top, bottom)
    for image, orientation in ((top, "top"), (bottom, "bottom")):
        verdict = classifier.judge(Face(image, similarity(image, top), similarity(image, bottom)))
        assert verdict.orientation == orientation
        assert (verdict.log_odds > 0) == (orientation == "top")


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_has_a_run_a_text_and_a_parser(name):
    run, text, add_arguments = COMMANDS[name]
    assert callable(run)
    assert callable(add_arguments)
    assert text
    assert not text.endswith(".")


HEAVY = {"cv2", "depthai", "numba", "numpy", "pywt", "scipy", "skimage"}


@pytest.mark.parametrize("module", ["appliance.supervisor.supervisor", "appliance.cli.main"])
def test_the_supervisor_and_the_command_line_load_no_image_library(module):
    code = f"import sys, {module}; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert module in loaded
    assert not HEAVY & set(loaded)
