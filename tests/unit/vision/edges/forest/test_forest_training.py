"""Labels, splits and trees of the forest on masks whose answer is known."""

import numpy as np
import pytest

from vision.edges.forest.features import sample, smoothed_cells
from vision.edges.forest.structured_labels import edge_pixels, medoid, two_classes
from vision.edges.forest.training import Example, _drawn, forest_of, train_tree
from vision.edges.forest.tree import Growth, _best


def halves(column: int) -> np.ndarray:
    """A mask that an upright border divides."""
    return (np.arange(16) >= column).astype(np.uint8) * np.ones((16, 1), np.uint8)


def test_two_classes_part_unlike_masks_whatever_their_segments_are_called():
    rng = np.random.default_rng(1)
    upright = [(halves(column) if n % 2 else 1 - halves(column)).ravel() for n, column in enumerate([7, 8, 9] * 20)]
    level = [halves(column).T.ravel() for column in [7, 8, 9] * 20]
    classes = two_classes(np.array(upright + level), rng)
    assert len(set(classes[:60])) == len(set(classes[60:])) == 1
    assert classes[0] != classes[-1]


def test_masks_that_only_differ_in_names_are_one_class():
    masks = np.array([halves(8).ravel(), 1 - halves(8).ravel()] * 10)
    assert len(set(two_classes(masks, np.random.default_rng(1)))) == 1


def test_the_medoid_is_the_mask_in_the_middle():
    masks = np.array([halves(column).ravel() for column in (5, 6, 7, 8, 9, 10, 11)])
    assert np.array_equal(medoid(masks, np.random.default_rng(1)), halves(8).ravel())


def test_an_edge_lies_on_both_sides_of_a_border():
    places = edge_pixels(halves(8).ravel())
    assert sorted(set((places % 16).tolist())) == [7, 8]
    assert len(places) == 32


def test_the_best_split_is_the_purest_one_of_all():
    rng = np.random.default_rng(3)
    values = rng.random((5, 200)).astype(np.float32)
    classes = ((values[3] > 0.6) ^ (rng.random(200) < 0.1)).astype(np.uint8)

    def gain(feature: int, threshold: float) -> float:
        left = values[feature] < threshold
        sides = [classes[side] for side in (left, ~left)]
        if min(map(len, sides)) < 8:
            return -1.0
        gini = [1 - side.mean() ** 2 - (1 - side.mean()) ** 2 for side in (classes, *sides)]
        return gini[0] - sum(len(side) / 200 * g for side, g in zip(sides, gini[1:], strict=True))

    best = max((gain(f, t), f, t) for f in range(5) for t in values[f])
    feature, threshold, found_gain = _best(values, classes, 8)
    assert feature == best[1] == 3
    assert found_gain == pytest.approx(best[0]) == gain(feature, threshold)


def bars(rng: np.random.Generator, count: int) -> list[Example]:
    """Bright upright bars on dark ground."""
    examples = []
    for _ in range(count):
        left = int(rng.integers(30, 60))
        segments = np.zeros((96, 128), np.int32)
        segments[:, left : left + 40] = 1
        noise = rng.normal(0, 0.01, (96, 128))
        examples.append(Example(np.clip(0.2 + 0.5 * segments + noise, 0, 1).astype(np.float32), (segments,)))
    return examples


def leaf(tree, cells: np.ndarray, place: tuple[int, int]) -> int:
    """The leaf that a patch reaches, walked by hand."""
    values = sample(cells, np.array([place]))[0]
    node = 0
    while tree.child[node]:
        node = tree.child[node] + (0 if values[tree.feature[node]] < tree.threshold[node] else 1)
    return node


def test_a_tree_votes_for_the_edge_of_a_bar_that_it_never_saw_and_for_nothing_inside():
    tree = train_tree(bars(np.random.default_rng(1), 20), 100, Growth(), np.random.default_rng(2))
    unseen = bars(np.random.default_rng(9), 1)[0]
    limb = int(np.flatnonzero(np.diff(unseen.segments[0][0]))[0])  # last pixel before the bar
    cells = smoothed_cells(unseen.image)
    column = (limb - 7) // 2
    at_limb = tree.edges[leaf(tree, cells, (20, column))]
    assert set(at_limb % 16) == {limb - 2 * column, limb - 2 * column + 1}
    assert tree.edges[leaf(tree, cells, (20, column + 10))].size == 0


def test_a_split_by_entropy_has_the_gain_of_the_printed_equation():
    rng = np.random.default_rng(6)
    values, classes = rng.random((4, 40)).astype(np.float32), (rng.random(40) < 0.4).astype(np.uint8)
    feature, threshold, gain = _best(values, classes, 5, True)

    def bits(labels):
        shares = np.bincount(labels, minlength=2) / len(labels)
        return -sum(share * np.log2(share) for share in shares if share)

    def gain_of(row, level):
        left, right = classes[row < level], classes[row >= level]
        return bits(classes) - len(left) / 40 * bits(left) - len(right) / 40 * bits(right)  # eq. 2.11

    levels = [(np.sort(row)[5:-5] + np.sort(row)[6:-4]) / 2 for row in values]
    assert gain == pytest.approx(
        max(gain_of(row, level) for row, at in zip(values, levels, strict=True) for level in at)
    )
    assert gain == pytest.approx(gain_of(values[feature], threshold))


def test_a_tree_grown_by_entropy_is_another_one_and_finds_the_bar_too():
    gini, entropy = (
        train_tree(bars(np.random.default_rng(1), 20), 100, Growth(criterion=name), np.random.default_rng(2))
        for name in ("gini", "entropy")
    )
    assert len(entropy.child) > 3
    assert not np.array_equal(gini.threshold, entropy.threshold)


def test_the_same_seed_grows_the_same_forest_and_another_seed_another_one():
    first, again, other = (
        train_tree(bars(np.random.default_rng(1), 6), 60, Growth(), np.random.default_rng(seed)) for seed in (2, 2, 3)
    )
    assert np.array_equal(first.threshold, again.threshold)
    assert all(np.array_equal(a, b) for a, b in zip(first.edges, again.edges, strict=True))
    assert not np.array_equal(first.threshold, other.threshold)


def test_trees_become_a_forest_that_keeps_their_nodes_and_edges():
    trees = [train_tree(bars(np.random.default_rng(n), 4), 60, Growth(), np.random.default_rng(n)) for n in range(3)]
    forest = forest_of(trees, 2)
    assert forest.trees == 3
    for tree, start in zip(trees, forest.tree_starts, strict=False):
        nodes = slice(start, start + len(tree.child))
        assert np.array_equal(forest.left_children[nodes], tree.child)
        for node, places in enumerate(tree.edges):
            span = forest.edge_starts[start + node], forest.edge_starts[start + node + 1]
            assert np.array_equal(forest.edge_places[slice(*span)], places)


def test_no_patch_is_drawn_where_nobody_can_tell():
    picture = bars(np.random.default_rng(1), 1)[0]
    unknown = np.full(picture.segments[0].shape, -1)
    with pytest.raises(ValueError, match="examples: "):
        train_tree([Example(picture.image, (unknown,))], 50, Growth(), np.random.default_rng(1))
    known = unknown.copy()
    known[:, :40] = picture.segments[0][:, :40]
    drawn = []
    train_tree([Example(picture.image, (known,))], 10_000, Growth(), np.random.default_rng(1), drawn.append)
    assert drawn[0] == 41 * 13  # places whose 16 x 16 pixels end before column 40


def test_places_are_drawn_evenly_or_where_the_picture_is_uneven():
    rng = np.random.default_rng(1)
    places, weight = np.arange(10_000), np.where(np.arange(10_000) < 1000, 9.0, 1.0).astype(np.float32)
    shares = [np.mean(_drawn(places, 500, rng, weight, part) < 1000) for part in (0.0, 0.5, 1.0)]
    assert shares == pytest.approx([0.1, 0.3, 0.5], abs=0.06)
    assert sorted(_drawn(places, 20_000, rng, weight, 0.5)) == places.tolist()
