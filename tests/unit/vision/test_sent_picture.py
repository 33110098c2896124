import numpy as np
import pytest

from vision.sent_picture import LUMA_709, Coding, SentPicture, sent_picture


def test_code_values_alone_are_what_they_look_like():
    image = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    picture = SentPicture.of(image)
    assert np.array_equal(picture.shown, image)
    assert np.array_equal(picture.measured, image)
    assert picture.size == (4, 2)
    assert SentPicture.of(picture) is picture


def test_twelve_bits_in_sixteen_are_not_dark():
    image = np.full((4, 4), 4095, np.uint16)
    picture = sent_picture(image, Coding("grey", 12))
    assert picture.shown.max() == 255
    assert picture.measured.max() == 4095


def test_limited_range_is_shown_in_full_range():
    image = np.array([[16, 235]], np.uint8)
    assert sent_picture(image, Coding("grey", full_range=False)).shown.tolist() == [[0, 255]]
    deep = np.array([[64, 940]], np.uint16)
    coding = Coding("grey", 10, full_range=False)
    assert (coding.black, coding.white) == (64, 940)
    assert sent_picture(deep, coding).shown.tolist() == [[0, 255]]


@pytest.mark.parametrize("pattern", ["RGGB", "GRBG", "GBRG", "BGGR"])
def test_a_mosaic_is_shown_in_its_colours(pattern):
    colour = {"R": 200, "G": 100, "B": 40}
    image = np.empty((16, 16), np.uint8)
    for site, name in enumerate(pattern):
        image[site // 2 :: 2, site % 2 :: 2] = colour[name]
    shown = sent_picture(image, Coding("mosaic", mosaic=pattern)).shown
    assert shown[8, 8].tolist() == [40, 100, 200]


@pytest.mark.parametrize(
    ("image", "coding", "message"),
    [
        (np.zeros((4, 4), np.float32), None, "uint8 or uint16"),
        (np.zeros((4, 4, 2), np.uint8), None, "grey or with three channels"),
        (np.zeros((0, 4), np.uint8), None, "grey or with three channels"),
        (np.zeros((4, 4, 3), np.uint8), Coding("luma", luma_weights=LUMA_709), "do not go with a coding of luma"),
    ],
)
def test_what_is_no_picture_is_a_wrong_call(image, coding, message):
    with pytest.raises(ValueError, match=message):
        _ = SentPicture.of(image) if coding is None else sent_picture(image, coding)


def test_a_coding_that_contradicts_itself_is_a_wrong_call():
    with pytest.raises(ValueError, match="bits: 8 to 16"):
        Coding("grey", 7)
    with pytest.raises(ValueError, match="mosaic: None does not go with"):
        Coding("mosaic")
