"""What is published of the passing bar and of several bars side by side."""

import math

import numpy as np
import pytest
from messages import reading

from appliance.conformity.mean_uncertainty import MeanUncertainty
from appliance.sizing.message import MESSAGES
from appliance.sizing.published import Publication
from plc.process_image import VALUE_NAMES, decode, encode
from vision.readings import SizeReading
from vision.reasons import Reason

BAR = {
    "bar_frames": 7, "bar_diameter_mm": 250.2, "bar_expanded_uncertainty_mm": 0.1, "bar_ovality_mm": 0.8,
    "bar_ovality_expanded_uncertainty_mm": 0.05, "camber_mm": -1.5, "u_camber_mm": 0.1, "axis_height_mm": 126.125,
}  # fmt: skip
NAMES = (
    "bar_frames", "bar_diameter", "bar_expanded_uncertainty", "bar_ovality", "bar_ovality_expanded_uncertainty",
    "camber", "camber_expanded_uncertainty", "hop_height", "bar_diameter_u16", "bar_expanded_uncertainty_u16",
)  # fmt: skip
SIDE_BY_SIDE = (
    SizeReading(diameter_mm=80.0, expanded_uncertainty_mm=0.2, offset_mm=-90.0, bar_diameter_mm=80.1, bar_frames=3),
    SizeReading(reasons=Reason.ONE_CAMERA),
    SizeReading(reasons=Reason.NO_BAR),
    SizeReading(diameter_mm=120.0, expanded_uncertainty_mm=0.3, offset_mm=90.0, reasons=Reason.SHIMMER),
)


def shown(block="measurement", **message):
    served = Publication(800)
    served.add(reading(**message))
    served.update(100.1, held=False)
    assert served.values().keys() <= VALUE_NAMES
    image = encode(served.values())
    data = image.words if block == "measurement" else image.bars
    return decode([int.from_bytes(data[place : place + 2]) for place in range(0, len(data), 2)], block=block)


def test_the_bar_s_values_stand_beside_those_of_the_frame():
    values = shown(**BAR)
    assert [values[name] for name in NAMES] == pytest.approx([7, 250.2, 0.1, 0.8, 0.05, -1.5, 0.2, 1.0, 250.2, 0.1])
    assert values["diameter"] == 250.25


def test_without_a_value_of_the_frame_there_is_none_of_the_bar():
    values = shown(reasons=Reason.VIEWS_DISAGREE, **BAR)
    assert {values[name] for name in NAMES} == {None}


def test_bars_side_by_side_stand_in_their_slots_and_the_single_value_is_none():
    message = {"reasons": Reason.SEVERAL_BARS, "diameter_mm": math.nan, "bars": SIDE_BY_SIDE}
    assert shown(**message)["diameter"] is None
    values = shown("bars", **message)
    assert values["bars_count"] == 3
    assert [values[f"bar_{n}_diameter"] for n in (1, 2, 3, 4)] == [80.0, None, None, 120.0]
    assert [values[f"bar_{n}_validity"] for n in (1, 2, 3, 4)] == [1, 0, 0, 2]
    assert values["bar_1_mean_diameter"] == pytest.approx(80.1)
    assert values["bar_2_reason_word"] == Reason.ONE_CAMERA
    assert [values["bar_1_offset"], values["bar_4_offset"]] == [-90.0, 90.0]


def test_one_bar_leaves_the_slots_empty():
    values = shown("bars")
    assert values["bars_count"] == 0
    assert {values[f"bar_{n}_diameter"] for n in (1, 2, 3, 4)} == {None}


def test_bars_side_by_side_cross_the_link():
    message = reading(reasons=Reason.SEVERAL_BARS, bars=SIDE_BY_SIDE)
    again = MESSAGES.validate_json(message.model_dump_json())
    assert [bar.reasons for bar in again.bars] == [bar.reasons for bar in SIDE_BY_SIDE]
    assert again.bars[0].diameter_mm == 80.0
    assert math.isnan(again.bars[1].diameter_mm)


@pytest.mark.parametrize("correlation", [0.0, 0.7])
def test_the_interval_of_a_bar_s_mean_holds(correlation):
    rng, inside, half = np.random.default_rng(2), 0, 0
    for _ in range(300):
        mean, noise, sizes = MeanUncertainty(), rng.normal(0, 0.1), []
        shared = rng.normal(0, 0.03)
        for _ in range(40):
            noise = correlation * noise + rng.normal(0, 0.1 * math.sqrt(1 - correlation**2))
            sizes.append(120 + shared + noise)
            own = {"u_edge_mm": 0.1, "u_motion_mm": 0.0}
            mean.add(SizeReading(diameter_mm=sizes[-1], expanded_uncertainty_mm=2 * math.hypot(0.1, 0.03), **own))
        error_mm = abs(np.mean(sizes) - 120)
        inside += error_mm <= mean.expanded_mm
        half += error_mm <= mean.expanded_mm / 2
    assert 0.92 <= inside / 300 <= 0.985
    assert half / 300 < 0.85
