"""What fusion is worth to route V: its error, the windows it sizes and the false edges near the bar, by each method.

`none` measures each view on its own and holds them against each other; `left` and `right` are one view alone, on the
plane that both gave and by its own place's model, and every other method is the fused picture alone. The forest is
left out, so that nothing here depends on how it was trained: Sobel's edges.
"""

from functools import lru_cache

import numpy as np
from calibrated_rigs import calibrated_rig

from appliance.simulation.bars.study_scenes import draw
from vision.alignment.quality import BarOutline
from vision.fusion.methods import METHODS
from vision.geometry.turned_region import resampled_region
from vision.reasons import Reason
from vision.sizing.virtual_board.aligned_pair import AlignedPair
from vision.sizing.virtual_board.boundaries_of_interest import boundaries_of_interest, hot_mask
from vision.sizing.virtual_board.gauge import VirtualBoardGauge
from vision.sizing.virtual_board.parameters import Parameters
from vision.sizing.virtual_board.reading import VirtualBoardReading
from vision.sizing.virtual_board.tangent_crossing import solve_section
from vision.sizing.virtual_board.view_edges import reasons_of_edges

TEXT = (
    "Route V on one picture out of two, by method; rigs, boards and calibrations as in served_diameter, 800 x 600, "
    "Sobel's edges. sized: windows kept of all; false_edges: edge pixels per row within 40 px of the bar's outline and "
    "further than 3 px from its edges in both views; edges_kept: share of rows and edges with one within 3 px."
)
CONDITIONS = ("clean", "scale", "post", "haze")
VARIANTS = ("none", "left", "right", *METHODS)
SEEDS = 60
NEAR_PX, AROUND_PX = 3.0, 40.0
SEEN = Parameters(beta=240.0, least_neighbours=1)  # edges from Otsu's level on, without single pixels


def cases():
    return [
        {"condition": condition, "seed": seed, "method": method}
        for seed in range(SEEDS)
        for condition in CONDITIONS
        for method in VARIANTS
    ]


def run(case, edges="sobel"):
    scene, watched = aligned(case["condition"], case["seed"], edges)
    watched.method = case["method"]
    reading = watched.again()
    result = {"valid": reading.valid, "sized": None, "error_mm": None, "false_edges": None, "edges_kept": None}
    if reading.windows_total:
        result["sized"] = reading.windows_kept / reading.windows_total
    if reading.valid:
        result["error_mm"] = reading.diameter_mm - scene.truth["diameter_mm"]
    return result | (watched.edges_seen() if watched.picture is not None else {})


@lru_cache(maxsize=1)
def aligned(condition, seed, edges):
    """A scene, and a gauge that has aligned its views."""
    scene, watched = draw(condition, seed), Watched(calibrated_rig(seed), edges)
    watched.measure(scene.left, scene.right)
    return scene, watched


class Watched(VirtualBoardGauge):
    """Route V that measures an aligned pair again by any method, and keeps the picture that it measured on."""

    def __init__(self, rig, edges):
        super().__init__(rig, edges=edges)
        self.method, self.picture, self.pair = "none", None, None

    def measure_bar(self, left, right, outlines):
        self.rough = outlines
        self.alone = super().measure_bar(left, right, outlines)
        return self.alone

    def read(self, pair, reasons):
        if self.method == "none":
            self.pair = pair
        return super().read(pair, reasons)

    def _fused(self, alignment, height_mm, method):
        region = super()._fused(alignment, height_mm, method)
        self.picture = region.picture
        return region

    def again(self):
        self.picture = None
        if self.method == "none" or self.pair is None:
            return self.alone
        self._uncorrupted_area = np.nan
        if self.method not in {"left", "right"}:
            return self._read_fused(self.pair, self.rough[0], self.method, Reason.NONE)
        alignment, height_mm = self.pair.alignment, self.pair.height.height_mm
        views = {"left": alignment.left.picture, "right": alignment.right_on_left(height_mm)}
        region = resampled_region(views[self.method], alignment.left)
        self.picture = region.picture
        edges = [self._view_edges(region, self.rough[0])]
        reasons = reasons_of_edges(edges)
        if reasons.forbids_value:
            return VirtualBoardReading(reasons=reasons)
        return super().read(AlignedPair(alignment, self.pair.height, edges, self.pair.outline), reasons)

    def _diameters(self, pair, width_mm):
        """One view alone is narrower or wider than the mean of both, by what the model says of its place."""
        if self.method in {"left", "right"} and np.isfinite(width_mm).any():
            cameras_mm, middle_mm = pair.section_frame()
            alone_mm, beyond_mm = float(np.nanmedian(width_mm)), 0.0
            for _ in range(3):
                section = solve_section(cameras_mm, pair.height.height_mm, alone_mm - beyond_mm, middle_mm)
                if section is not None:
                    beyond_mm = section.width_mm[int(self.method == "right")] - section.width_mm.mean()
            width_mm = width_mm - beyond_mm
        return super()._diameters(pair, width_mm)

    def edges_seen(self):
        thin = boundaries_of_interest(self.picture, hot_mask(self.picture), self._edges, SEEN).thin
        row, column = np.nonzero(thin)
        true = self.true_columns(len(thin))
        away = np.abs(column[:, None] - true.reshape(-1, len(thin))[:, row].T)
        near = away.min(axis=1) <= NEAR_PX
        around = (column >= true.min(axis=(0, 1))[row] - AROUND_PX) & (column <= true.max(axis=(0, 1))[row] + AROUND_PX)
        first = column < true.mean(axis=(0, 1))[row]
        kept = [np.unique(row[near & side]).size for side in (first, ~first)]
        return {
            "false_edges": float(np.sum(~near & around) / len(thin)),
            "edges_kept": sum(kept) / 2 / len(thin),
        }

    def true_columns(self, rows):
        """Columns of the bar's edges in each row of the left region, shape (views, edges, rows)."""
        onto = self.pair.alignment.right_to_left(self.pair.height.height_mm)
        left, right = (view.outline for view in self.pair.edges)
        return np.array([columns(left, rows), columns(right.moved(onto), rows)])


def columns(outline: BarOutline, rows):
    at = np.arange(rows)
    lines = []
    for edge in (outline.first, outline.second):
        (x0, y0), (x1, y1) = edge[0], edge[-1]
        lines.append(x0 + (x1 - x0) / (y1 - y0) * (at - y0))
    return np.array(lines)


def summary(rows):
    return {
        condition: {
            method: _told([row for row in rows if row["condition"] == condition and row["method"] == method])
            for method in VARIANTS
        }
        for condition in CONDITIONS
    }


def _told(rows):
    def mean(key):
        values = [row[key] for row in rows if row[key] is not None]
        return round(float(np.mean(values)), 4) if values else None

    errors = np.array([row["error_mm"] for row in rows if row["valid"]])
    told = {"frames": len(rows), "valid": int(sum(row["valid"] for row in rows))}
    told |= {key: mean(key) for key in ("sized", "false_edges", "edges_kept")}
    if errors.size:
        told |= {
            "rmse_mm": round(float(np.sqrt(np.mean(errors**2))), 4),
            "median_abs_mm": round(float(np.median(np.abs(errors))), 4),
            "bias_mm": round(float(errors.mean()), 4),
            "worst_mm": round(float(np.abs(errors).max()), 4),
        }
    return told
