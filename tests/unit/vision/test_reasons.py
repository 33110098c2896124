"""Reason bits: the contract with PLC programmers, written down a second time; a bit never changes its meaning."""

from vision.reasons import INGOT_REASONS, REASONS

BITS = {
    "no_bar": 0,
    "one_camera": 1,
    "several_bars": 2,
    "edge_not_found": 3,
    "fit_failed": 4,
    "views_disagree": 5,
    "implausible": 6,
    "no_pair": 7,
    "stale": 8,
    "starting": 9,
    "edges_clipped": 10,
    "held": 11,
    "no_windows": 12,
    "not_aligned": 13,
    "camera_moved": 14,
    "bar_too_short": 15,
    "some_edges_clipped": 16,
    "low_contrast": 17,
    "few_windows": 18,
    "barrier_height": 19,
    "poor_alignment": 20,
    "board_held": 21,
    "adjusted": 22,
    "uncertainty_unknown": 23,
    "routes_disagree": 24,
    "calibration_due": 25,
    "limb_hidden": 26,
    "bar_head": 27,
    "bar_tail": 28,
    "barrier_hidden": 29,
    "barrier_bent": 30,
    "shimmer": 31,
}
INGOT_BITS = {
    "nothing_hot": 0,
    "hanging": 1,
    "outside": 2,
    "too_small": 3,
    "too_large": 4,
    "tilted": 5,
    "no_circle": 6,
    "no_picture": 7,
    "stale": 8,
    "starting": 9,
    "held": 10,
    "glare_joined": 12,
    "several_ends": 13,
    "overexposed": 14,
}


def test_every_reason_has_the_bit_of_the_contract_and_no_other():
    assert {row.name: row.flag.bit_length() - 1 for row in REASONS} == BITS
    assert {row.name: row.flag.bit_length() - 1 for row in INGOT_REASONS} == INGOT_BITS


def test_a_reason_is_one_bit():
    assert all(row.flag.bit_count() == 1 for row in (*REASONS, *INGOT_REASONS))
