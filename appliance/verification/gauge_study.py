"""Gauge study: repeatability and reproducibility by analysis of variance (AIAG MSA, 4th edition).

In place of the appraisers of a hand gauge stand conditions: places along the line, days, calibrations.
"""

import csv
import math
import statistics
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

from appliance.errors import HotgaugeError, reading_advice

COLUMNS = ("bar", "condition", "diameter_mm")
DEVIATIONS_OF_TOLERANCE = 6  # AIAG: 6 standard deviations against the tolerance's width
CATEGORIES_FACTOR = math.sqrt(2)  # 1.41 in AIAG's forms
POOLING_F = 2.0  # an interaction with a smaller F ratio counts as repeatability; AIAG tests it at alpha = 0.05


class StudyError(HotgaugeError):
    """The measurements are no gauge study; the message says what, where and what to do."""


class GaugeStudy(NamedTuple):
    """Outcome of a gauge study, standard deviations in mm.

    Attributes
    ----------
    bars, conditions, trials : int
    repeatability_mm : float
        EV: the same bar again under the same condition.
    reproducibility_mm : float
        AV: between conditions, with their interaction with bars.
    gauge_mm : float
        GRR: both together.
    bars_mm : float
        PV: between bars.
    total_mm : float
        TV.
    categories : int
        Number of distinct categories, at least 1; five and more are wanted.
    """

    bars: int
    conditions: int
    trials: int
    repeatability_mm: float
    reproducibility_mm: float
    gauge_mm: float
    bars_mm: float
    total_mm: float
    categories: int

    @property
    def percent_of_variation(self) -> float:
        """GRR over TV, percent; below 10 is good, above 30 is not acceptable (AIAG)."""
        return 100 * self.gauge_mm / self.total_mm

    def percent_of_tolerance(self, tolerance_mm: float) -> float:
        """6 GRR over the tolerance's whole width, percent."""
        return 100 * DEVIATIONS_OF_TOLERANCE * self.gauge_mm / tolerance_mm


Cells = dict[tuple[str, str], list[float]]
"""Diameters of each bar under each condition."""


def gauge_study(cells: Cells) -> GaugeStudy:
    """Analyse diameters of bars under conditions.

    Parameters
    ----------
    cells : dict of (str, str) to list of float
        Diameters in mm, by bar and condition.

    Raises
    ------
    StudyError
        Fewer than two bars, conditions or trials, a bar that was not measured under each condition, or measurements
        that are all equal.
    """
    bars = sorted({bar for bar, _ in cells})
    conditions = sorted({condition for _, condition in cells})
    trials = {len(cells.get((bar, condition), ())) for bar in bars for condition in conditions}
    if len(bars) < 2 or len(conditions) < 2 or len(trials) != 1 or min(trials) < 2:
        raise StudyError("two bars and two conditions at least, and each bar equally often, at least twice, under each")
    count = trials.pop()
    b, c = len(bars), len(conditions)
    grand = statistics.fmean(value for values in cells.values() for value in values)
    bar_means = [statistics.fmean(v for k in conditions for v in cells[bar, k]) for bar in bars]
    condition_means = [statistics.fmean(v for bar in bars for v in cells[bar, k]) for k in conditions]
    of_bars = c * count * sum((mean - grand) ** 2 for mean in bar_means)
    of_conditions = b * count * sum((mean - grand) ** 2 for mean in condition_means)
    of_cells = count * sum((statistics.fmean(values) - grand) ** 2 for values in cells.values())
    within = sum((value - statistics.fmean(values)) ** 2 for values in cells.values() for value in values)
    square_b, square_c = of_bars / (b - 1), of_conditions / (c - 1)
    square_bc, square_e = (of_cells - of_bars - of_conditions) / ((b - 1) * (c - 1)), within / (b * c * (count - 1))
    if square_bc < POOLING_F * square_e:
        freedom = (b - 1) * (c - 1) + b * c * (count - 1)
        square_bc = square_e = (of_cells - of_bars - of_conditions + within) / freedom
    interaction = max(0.0, (square_bc - square_e) / count)
    reproducibility = max(0.0, (square_c - square_bc) / (b * count)) + interaction
    bars_variance = max(0.0, (square_b - square_bc) / (c * count))
    gauge = square_e + reproducibility
    if not gauge > 0:
        raise StudyError("all measurements are equal; give more digits")
    categories = max(1, math.floor(CATEGORIES_FACTOR * math.sqrt(bars_variance / gauge)))
    return GaugeStudy(
        b,
        c,
        count,
        repeatability_mm=math.sqrt(square_e),
        reproducibility_mm=math.sqrt(reproducibility),
        gauge_mm=math.sqrt(gauge),
        bars_mm=math.sqrt(bars_variance),
        total_mm=math.sqrt(gauge + bars_variance),
        categories=categories,
    )


def read_cells(file: Path) -> Cells:
    """Diameters of a CSV file with the columns bar, condition and diameter_mm.

    Parameters
    ----------
    file : Path

    Raises
    ------
    StudyError
        The file cannot be read, lacks a column, or holds something that is no number.
    """
    cells: Cells = defaultdict(list)
    try:
        with file.open(newline="", encoding="utf-8-sig") as text:
            rows = csv.DictReader(text)
            if any(";" in name for name in rows.fieldnames or ()):
                raise StudyError(
                    f"{file}: its cells are parted by semicolons; save it with commas, and decimals with points"
                )
            for row in rows:
                cells[row["bar"], row["condition"]].append(float(row["diameter_mm"]))
    except OSError as error:
        raise StudyError(f"{file}: {error.strerror}; {reading_advice(error, 'give an existing CSV file')}") from error
    except KeyError as error:
        raise StudyError(f"{file}: has no column {error.args[0]}; it needs the columns {', '.join(COLUMNS)}") from error
    except (ValueError, TypeError, csv.Error) as error:
        raise StudyError(f"{file}: {error}; it needs the columns {', '.join(COLUMNS)}, with numbers") from error
    return cells
