"""Pictures of the line as cameras send them: light in all its steps, and what a coder left out in the uncertainty."""

from dataclasses import replace

import numpy as np
import pytest
from coded_pictures import DEEPER_CODINGS, all_sent, deep

from appliance.simulation.bars.bars import Bar
from appliance.simulation.thermal_line import ThermalLine, thermal_camera
from vision.sent_picture import Coding, SentPicture, sent_picture
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge
from vision.sizing.conveyor.grey_light import grey_light

LINE = ThermalLine(thermal_camera(), bar=Bar(165.0, 20.0, 0.0), seed=3)
REFERENCE = ConveyorReference(LINE.spacing_mm, LINE.height_mm, float(LINE.camera.centre_mm[2]))
CODES = np.arange(256, dtype=np.uint8).reshape(16, 16)


@pytest.fixture(scope="module")
def pictures():
    return LINE.pictures(2, 1)


def measured(pictures, name):
    *empty, shown = all_sent(pictures, DEEPER_CODINGS[name])
    return ConveyorGauge(empty, REFERENCE, response_exponent=1.0).measure(shown)


def test_luma_of_limited_range_is_light_from_16_to_235():
    luma = sent_picture(CODES, Coding("luma", full_range=False), np.zeros((16, 16, 3), np.uint8))
    expected = np.clip((np.arange(256) - 16) / 219, 0, 1)
    assert grey_light(luma).ravel() == pytest.approx(expected, abs=1e-6)
    assert grey_light(luma, 0.5).ravel() == pytest.approx(expected**2, abs=1e-6)


def test_the_steps_between_8_bit_codes_are_kept():
    fine = np.arange(1024, dtype=np.uint16).reshape(32, 32)
    light = grey_light(sent_picture(fine, Coding("grey", bits=10)))
    assert len(np.unique(light)) == 1024
    assert light.max() == 1.0


def test_grey_of_colours_and_of_a_mosaic_is_that_of_the_picture_shown():
    colours = np.random.default_rng(0).integers(0, 256, (8, 8, 3)).astype(np.uint8)
    shown = 0.114 * colours[..., 0] + 0.587 * colours[..., 1] + 0.299 * colours[..., 2]
    assert grey_light(colours) == pytest.approx(shown / 255, abs=0.5 / 255 + 1e-3)
    mosaic = sent_picture(CODES, Coding("mosaic", mosaic="RGGB"))
    assert grey_light(mosaic).shape == CODES.shape


def test_deep_pictures_measure_the_bar_of_the_8_bit_ones(pictures):
    fine = [SentPicture.of(one) for one in deep(pictures)]
    reading = ConveyorGauge(fine[:2], REFERENCE, response_exponent=1.0).measure(fine[2])
    assert reading.u_light_mm == 0.0
    assert reading.diameter_mm == pytest.approx(measured(pictures, "png").diameter_mm, abs=0.05)


@pytest.mark.parametrize("name", ["jpeg 4:2:0 q75", "h264 crf 23", "h264 crf 28"])
def test_u_of_a_coded_line_holds_and_says_that_it_was_coded(pictures, name):
    plain, coded = measured(pictures, "png"), measured(pictures, name)
    assert abs(coded.diameter_mm - LINE.bar.diameter_mm) <= coded.expanded_uncertainty_mm
    assert coded.u_light_mm > 0.0
    assert coded.u_calibration_mm > plain.u_calibration_mm


def test_a_picture_of_the_empty_line_that_was_stored_without_loss_is_doubted_as_its_camera_s(pictures):
    *empty, shown = all_sent(pictures, DEEPER_CODINGS["h264 crf 28"])
    stored = [SentPicture(one.shown, one.measured, replace(one.coding, compression="none")) for one in empty]
    told, untold = (ConveyorGauge(one, REFERENCE, response_exponent=1.0).measure(shown) for one in (empty, stored))
    assert untold.expanded_uncertainty_mm == pytest.approx(told.expanded_uncertainty_mm, rel=0.05)
