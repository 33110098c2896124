"""The dissertation's stereo method from stock parts, as its reader would write it down first; a timed child process.

Algorithms 8 to 13 in their order, whole pictures, one statement for each step of the text: OpenCV contrib's structured
forest with its own thinning, Otsu, morphology, contours, k-means, numpy's polyfit, homographies of interpolated boards.
Fusion is left out. Its diameter is as wrong as the printed method is where a bar does not run along the columns: only
its time is of interest. It runs beside the gauge, in the environment of the contrib wheel, and imports nothing of it.

Arguments: the forest in OpenCV's format and a rig (`numpy.savez`: `board_mm`, shape (n, 2), its corners in each view,
`left_low` to `right_high`, shape (n, 2), pixel, and the two heights `low_mm` and `high_mm`). Each line of standard
input, the path of a pair of BGR pictures (`numpy.savez`: `left`, `right`), is answered by the wall and processor
milliseconds of one measurement and by the diameter in mm.
"""

import sys
import time
from dataclasses import dataclass

import cv2
import numpy as np

WINDOW_ROWS = 5  # H of algorithm 9
SAMPLINGS = 10  # T
SAMPLED_SHARE = 0.5  # S, as a share of a boundary's points
STRENGTH_FLOOR = 0.2  # beta, on a scale that ends at 1
BOARDS = 21  # n of algorithm 13
TRUSTED_DEVIATIONS = 2.0  # windows whose weighted deviation lies further from its mean are not trusted
KERNEL = np.ones((5, 5), np.uint8)


@dataclass
class View:
    """Algorithm 8 of one picture: the bar's mask and the boundaries of interest around its edges."""

    mask: np.ndarray
    boundaries: np.ndarray


def boundaries_of_interest(forest, picture):
    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    _, binary = cv2.threshold(grey, 0, 255, cv2.THRESH_OTSU)
    mask = cv2.dilate(cv2.morphologyEx(binary, cv2.MORPH_OPEN, KERNEL), KERNEL, iterations=2)
    colour = cv2.cvtColor(picture, cv2.COLOR_BGR2RGB).astype(np.float32) / 255
    strength = forest.detectEdges(colour)
    sharp = forest.edgesNms(strength, forest.computeOrientation(strength))
    kept = np.where((mask > 0) & (sharp > STRENGTH_FLOOR), 255, 0).astype(np.uint8)
    closed = cv2.morphologyEx(kept, cv2.MORPH_CLOSE, KERNEL)
    contours, _ = cv2.findContours(closed, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    boundaries = np.zeros_like(closed)
    cv2.drawContours(boundaries, [one for one in contours if len(one) > 2 * WINDOW_ROWS], -1, 255, 1)
    return View(binary, boundaries)


def board_at(rig, side, share):
    return (1 - share) * rig[f"{side}_low"] + share * rig[f"{side}_high"]


def agreed_share(rig, left, right):
    """Algorithms 11 to 13: the virtual board on which the two masks of the bar overlap most."""
    rows, columns = left.mask.shape
    middle = rig["left_low"][:, 1].mean()
    tested = slice(int(max(0, middle - rows / 8)), int(middle + rows / 8))
    qualities = []
    shares = np.linspace(0.0, 1.0, BOARDS)
    for share in shares:
        homography, _ = cv2.findHomography(board_at(rig, "right", share), board_at(rig, "left", share))
        moved = cv2.warpPerspective(right.mask, homography, (columns, rows))[tested] > 0
        still = left.mask[tested] > 0
        qualities.append(np.count_nonzero(moved & still) / max(1, np.count_nonzero(still)))
    return shares[int(np.argmax(qualities))]


def window_diameters(rng, boundaries, top, homography):
    """Algorithm 9 and eq. 3.15: T diameters of one window, and the mean area of its two boundaries."""
    y, x = np.nonzero(boundaries[top : top + WINDOW_ROWS])
    if len(x) < 2 * WINDOW_ROWS:
        return None
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 10, 0.1)
    _, labels, _ = cv2.kmeans(x.astype(np.float32)[:, None], 2, None, criteria, 1, cv2.KMEANS_PP_CENTERS)
    rows = np.arange(top, top + WINDOW_ROWS)
    diameters, area = [], np.ptp(x[labels[:, 0] == 0]) + np.ptp(x[labels[:, 0] == 1])
    for _ in range(SAMPLINGS):
        edges = []
        for cluster in (0, 1):
            (members,) = np.nonzero(labels[:, 0] == cluster)
            if len(members) < 4:
                return None
            chosen = rng.choice(members, max(4, int(SAMPLED_SHARE * len(members))))
            if np.ptp(y[chosen]) == 0:
                return None
            slope, offset = np.polyfit(top + y[chosen], x[chosen], 1)
            points = np.stack([slope * rows + offset, rows], axis=1)[None].astype(np.float64)
            edges.append(cv2.perspectiveTransform(points, homography)[0])
        diameters.append(np.linalg.norm(edges[0] - edges[1], axis=1).mean())
    return np.array(diameters), WINDOW_ROWS * area / 2


def view_diameter(rng, view, board_px, board_mm):
    """Algorithm 10 and eq. 3.16 to 3.19: the mean of the trusted windows."""
    homography, _ = cv2.findHomography(board_px, board_mm)
    first, last = int(board_px[:, 1].min()), int(board_px[:, 1].max())
    windows = [
        window
        for top in range(max(0, first), min(last, len(view.boundaries) - WINDOW_ROWS), WINDOW_ROWS)
        if (window := window_diameters(rng, view.boundaries, top, homography)) is not None
    ]
    if not windows:
        return np.nan
    means, deviations = (np.array([part(one) for one, _ in windows]) for part in (np.mean, np.std))
    areas = np.array([area for _, area in windows])
    ratio = areas / np.median(areas)
    weighted = ratio**2 * np.exp(ratio - 1) * deviations
    trusted = weighted <= weighted.mean() + TRUSTED_DEVIATIONS * weighted.std()
    return float(np.median(means[trusted]))


def diameter_mm(forest, rig, left, right):
    """The mean of both views' diameters, on the board at the height at which they agree."""
    rng = np.random.default_rng(1)
    views = [boundaries_of_interest(forest, picture) for picture in (left, right)]
    share = agreed_share(rig, *views)
    return np.mean(
        [
            view_diameter(rng, view, board_at(rig, side, share), rig["board_mm"])
            for side, view in zip(("left", "right"), views, strict=True)
        ]
    )


def main():
    forest = cv2.ximgproc.createStructuredEdgeDetection(sys.argv[1])
    rig = dict(np.load(sys.argv[2]))
    print("ready", flush=True)
    for line in sys.stdin:
        pair = np.load(line.strip())
        left, right = pair["left"], pair["right"]
        wall, cpu = time.perf_counter(), time.process_time()
        diameter = diameter_mm(forest, rig, left, right)
        print(1000 * (time.perf_counter() - wall), 1000 * (time.process_time() - cpu), diameter, flush=True)


if __name__ == "__main__":
    main()
