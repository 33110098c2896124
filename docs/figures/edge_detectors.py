"""Sobel, Canny and the forest at three thresholds each, on the empty line and on a hot bar with scale.

After figures 3.3 to 3.14 of the dissertation, with our own scenes.
"""

from pathlib import Path

import cv2
import numpy as np
from matplotlib import pyplot as plt

from appliance.simulation.bars.study_scenes import draw
from vision.edges.binary import BAR_EDGE_CONFIDENCE, EVERY_EDGE_CONFIDENCE, binarised, denoised
from vision.edges.operators import canny, detect_edges
from vision.edges.thinning import ridges

SEED = 3
SCENES = (("the empty line", "no-bar"), ("a hot bar with scale", "scale"))
SOBEL = ((0.05, 0.015, 0.01), (0.02, 0.05, 0.09))  # the second row as in the dissertation
CANNY = (((0.04, 0.1), (0.02, 0.05), (0.012, 0.03)), ((0.0064, 0.016), (0.04, 0.1), (0.22, 0.55)))
FOREST = (EVERY_EDGE_CONFIDENCE, BAR_EDGE_CONFIDENCE, 0.3)  # 0.3: the dissertation's confidence for a close-up


def lines(image, method, confidence):
    """Thin edges of at least this strength, lone pixels taken away."""
    found = detect_edges(image, method)
    return denoised(binarised(ridges(found.strength, found.normal_rad), confidence))


def save(folder: Path) -> None:
    """Draw `edge_detectors.png` into a folder."""
    figure, axes = plt.subplots(6, 4, figsize=(12, 13.5))
    for number, (name, condition) in enumerate(SCENES):
        picture = draw(condition, SEED).left
        colour = cv2.cvtColor(picture, cv2.COLOR_BGR2RGB).astype(np.float32) / 255
        grey = np.asarray(cv2.cvtColor(colour, cv2.COLOR_RGB2GRAY), np.float32)
        rows = (
            ("Sobel", [(f"threshold {t}", lines(colour, "sobel", t)) for t in SOBEL[number]]),
            ("Canny", [(f"pair {low}, {high}", canny(grey, low, high).strength > 0) for low, high in CANNY[number]]),
            ("forest", [(f"confidence {t:.0%}", lines(colour, "forest", t)) for t in FOREST]),
        )
        for row, (method, pictures) in enumerate(rows):
            of_row = axes[3 * number + row]
            of_row[0].set_ylabel(method)
            of_row[0].imshow(np.clip(colour * (2 if condition == "no-bar" else 1), 0, 1))
            of_row[0].set_title(name, fontsize=9)
            for ax, (title, edges) in zip(of_row[1:], pictures, strict=True):
                ax.imshow(~edges, cmap="gray", vmin=0, vmax=1, interpolation="antialiased")
                ax.set_title(title, fontsize=9)
    for ax in axes.flat:
        ax.set(xticks=[], yticks=[])
    figure.tight_layout()
    figure.savefig(folder / "edge_detectors.png", dpi=60)
