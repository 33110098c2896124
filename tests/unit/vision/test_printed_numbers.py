"""Numbers that the dissertation prints, as they stand there: whoever changes one changes its methods."""

import pytest

from vision.edges import binary, operators
from vision.ingot.classifiers.similarity import Comparison, Exponents
from vision.ingot.end_finder import EndLimits
from vision.sizing.conveyor import published_experiments
from vision.sizing.virtual_board.parameters import PRINTED_PARAMETERS

PRINTED = (
    ("Canny's thresholds, section 3.1", operators.CANNY_THRESHOLDS, (0.02, 0.05)),
    ("the forest's confidence for the empty line, section 3.2", binary.EVERY_EDGE_CONFIDENCE, 0.02),
    ("and for a bar", binary.BAR_EDGE_CONFIDENCE, 0.2),
    ("neighbours of algorithm 4", binary.LEAST_NEIGHBOURS, 2),
    ("w of algorithm 7, columns", published_experiments.AREA_COLUMNS, 85),
    ("h of algorithm 7, rows", published_experiments.AREA_ROWS, 20),
    ("s of algorithm 7", published_experiments.AREA_STRIDE_PX, 5),
    ("sets of points of eq. 3.6", published_experiments.SET_COUNT, 5),
    ("alpha, section 3.7", PRINTED_PARAMETERS.alpha, 0.95),
    ("beta, section 3.7", PRINTED_PARAMETERS.beta, 240),
    ("neighbours as printed", PRINTED_PARAMETERS.least_neighbours, 2),
    ("H, section 3.7", PRINTED_PARAMETERS.window_rows, 5),
    ("T, section 3.5", PRINTED_PARAMETERS.sample_count, 10),
    ("exponents of eq. 6.1", Exponents(), (1, 1, 1)),
    ("threshold of the single classifier, section 6.4", Comparison().threshold, 0.75),
)


@pytest.mark.parametrize(("number", "printed"), [row[1:] for row in PRINTED], ids=[row[0] for row in PRINTED])
def test_a_number_is_the_printed_one(number, printed):
    assert number == printed


def test_limits_of_algorithm_15_are_the_printed_ones():
    limits = EndLimits()
    assert (limits.area_px, limits.tilt_deg) == ((5000, 14000), 15)
