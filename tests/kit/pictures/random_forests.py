"""A forest nobody trained: every patch still finds its way to a leaf, and every leaf holds a line or nothing."""

import numpy as np

from vision.edges.forest.features import FEATURES, places_along, sample, smoothed_cells
from vision.edges.forest.model import StructuredForest


def random_picture(rows, columns, seed=0, colours=3):
    """Blurred discs of all sizes under noise, float32 in 0 to 1."""
    random = np.random.default_rng(seed)
    y, x = np.mgrid[:rows, :columns].astype(np.float32)
    picture = np.full((rows, columns, colours), random.random(colours), np.float32)
    for _ in range(25):
        radius = random.uniform(4, max(rows, columns) / 5)
        distance = np.hypot(y - random.uniform(0, rows), x - random.uniform(0, columns))
        inside = np.clip((radius - distance) / random.uniform(0.7, 3), 0, 1)[:, :, None]
        picture += inside * (random.random(colours) - picture)
    picture += random.normal(0, 0.02, picture.shape)
    picture = (np.rint(255 * np.clip(picture, 0, 1)) / 255).astype(np.float32)
    return picture[:, :, 0] if colours == 1 else picture


def random_tree(random, patches, depth):
    """Left children, feature ids, thresholds, edge places of each node; splits lie within the patches' values."""
    left, ids, thresholds, edges = [0], [0], [0.0], [np.array([], int)]
    waiting = [(0, np.arange(len(patches)), 0)]
    while waiting:
        node, here, level = waiting.pop(0)
        feature = int(random.integers(FEATURES))
        values = patches[here, feature]
        threshold = np.float32(np.quantile(values, random.uniform(0.2, 0.8)))
        goes_left = values < threshold
        if level == depth or goes_left.all() or not goes_left.any():
            if random.random() < 0.6:
                angle, y, x = random.uniform(0, np.pi), *random.uniform(3, 12, 2)
                steps = np.arange(-20, 20, 0.5)
                line = np.unique(np.rint([y + steps * np.sin(angle), x + steps * np.cos(angle)]).astype(int), axis=1)
                line = line[:, ((line >= 0) & (line < 16)).all(axis=0)]
                edges[node] = 16 * line[0] + line[1]
            continue
        left[node], ids[node], thresholds[node] = len(left), feature, threshold
        for part in (here[goes_left], here[~goes_left]):
            waiting.append((len(left), part, level + 1))
            left.append(0)
            ids.append(0)
            thresholds.append(0.0)
            edges.append(np.array([], int))
    return left, ids, thresholds, edges


def random_forest(seed=0, trees=8, trees_evaluated=4, depth=10, patches=600):
    random = np.random.default_rng(seed)
    cells = smoothed_cells(random_picture(240, 320, seed))
    places = np.column_stack(
        (random.integers(places_along(240), size=patches), random.integers(places_along(320), size=patches))
    )
    samples = sample(cells, places)
    grown = [random_tree(random, samples, depth) for _ in range(trees)]
    edges = [places for tree in grown for places in tree[3]]
    return StructuredForest(
        tree_starts=np.cumsum([0, *(len(tree[0]) for tree in grown)]).astype(np.int32),
        left_children=np.concatenate([tree[0] for tree in grown]).astype(np.int32),
        feature_ids=np.concatenate([tree[1] for tree in grown]).astype(np.int32),
        thresholds=np.concatenate([tree[2] for tree in grown]).astype(np.float32),
        edge_starts=np.cumsum([0, *map(len, edges)]).astype(np.int32),
        edge_places=np.concatenate(edges).astype(np.uint8),
        trees_evaluated=trees_evaluated,
    )
