import cv2
import numpy as np
import pytest
from skimage import data

from appliance.cameras.section import EmptyLine
from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.study_scenes import draw
from appliance.simulation.thermal_line import ThermalLine, thermal_camera
from appliance.sizing.conveyor.empty_line import EmptyLineError, TimedConveyorGauge
from vision.pictures import is_false_colour
from vision.sent_picture import SentPicture

PALETTES = ["JET", "INFERNO", "PLASMA", "RAINBOW", "TURBO", "HSV", "VIRIDIS", "HOT", "OCEAN", "WINTER", "PINK"]


@pytest.fixture(scope="module")
def thermal():
    return list(ThermalLine(thermal_camera(), bar=Bar(130.0)).pictures(1, 1))


@pytest.mark.parametrize("palette", PALETTES)
def test_a_thermal_picture_in_a_palettes_colours_is_told_from_light(thermal, palette):
    grey = thermal[1] if thermal[1].ndim == 2 else thermal[1][:, :, 1]
    assert is_false_colour(cv2.applyColorMap(grey, getattr(cv2, f"COLORMAP_{palette}")))


def test_light_is_not_taken_for_a_palette(thermal):
    assert not any(map(is_false_colour, thermal))
    assert not is_false_colour(np.repeat(np.atleast_3d(thermal[1])[:, :, :1], 3, axis=2))
    assert not is_false_colour(data.coffee())
    for seed in range(2):
        scene = draw("rollers", seed)
        assert not is_false_colour(scene.left)
        assert not is_false_colour(scene.right)


def test_false_colours_are_refused_in_one_sentence(thermal):
    grey = thermal[1] if thermal[1].ndim == 2 else thermal[1][:, :, 1]
    coloured = cv2.applyColorMap(grey, cv2.COLORMAP_JET)
    with pytest.raises(EmptyLineError, match=r"background.png: .* in false colours.*record grey values$"):
        TimedConveyorGauge(EmptyLine([SentPicture.of(coloured)], "background.png"), lambda _: None)
