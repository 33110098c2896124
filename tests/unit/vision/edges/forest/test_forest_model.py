"""The forest's file: written and read as it was, and refused when damaged."""

import io
from dataclasses import fields, replace

import numpy as np
import pytest
from opencv_format import read_opencv, write_opencv
from random_forests import random_forest

from vision.edges.forest.model import StructuredForest, shipped_forest


@pytest.fixture(scope="module")
def forest():
    return random_forest(seed=5, depth=4, patches=200)


def same(one, other):
    return all(np.array_equal(getattr(one, field.name), getattr(other, field.name)) for field in fields(one))


def intact(content, forest):
    """Whether a file holds the forest still; whatever else it holds must be refused in the reader's words."""
    try:
        return same(StructuredForest.load(io.BytesIO(content)), forest)
    except ValueError as error:
        if "forest model" not in str(error):
            raise
        return False


def changed(array, place, value):
    copy = array.copy()
    copy[place] = value
    return copy


def test_a_forest_comes_back_from_a_file_as_it_was(forest, tmp_path):
    forest.save(tmp_path / "forest.npz")
    assert same(StructuredForest.load(tmp_path / "forest.npz"), forest)
    memory = io.BytesIO()
    forest.save(memory)
    memory.seek(0)
    assert same(StructuredForest.load(memory), forest)


def test_the_shipped_forest_is_read_once():
    assert shipped_forest() is shipped_forest()
    assert shipped_forest().trees == 8


@pytest.mark.parametrize("ending", [".yml", ".yml.gz"])
def test_a_forest_comes_back_from_opencvs_format(forest, tmp_path, ending):
    assert len(set(np.diff(forest.tree_starts).tolist())) > 1  # so that trees are filled up
    write_opencv(forest, tmp_path / f"forest{ending}")
    assert same(read_opencv(tmp_path / f"forest{ending}"), forest)


@pytest.mark.parametrize(
    ("name", "change", "error"),
    [
        ("thresholds", lambda a: a.astype(np.float64), TypeError),
        ("edge_places", lambda a: a.tolist(), TypeError),
        ("left_children", lambda a: a[:, None], ValueError),
        ("tree_starts", lambda a: changed(a, 0, 1), ValueError),
        ("tree_starts", lambda a: changed(a, 1, a[2]), ValueError),
        ("left_children", lambda a: changed(a, 0, len(a)), ValueError),
        ("left_children", lambda a: changed(a, 0, -1), ValueError),
        ("left_children", lambda a: changed(a, np.flatnonzero(a)[1], 1), ValueError),  # two parents
        ("left_children", lambda a: changed(a, np.flatnonzero(a)[1], 0), ValueError),  # nodes nobody reaches
        ("left_children", lambda a: changed(a, np.flatnonzero(a)[3], 2), ValueError),  # back to an ancestor
        ("feature_ids", lambda a: changed(a, 0, 7228), ValueError),
        ("feature_ids", lambda a: a[:-1], ValueError),
        ("thresholds", lambda a: changed(a, 0, np.nan), ValueError),
        ("edge_starts", lambda a: changed(a, -1, a[-1] + 1), ValueError),
        ("edge_starts", lambda a: changed(a, 5, a[-1] + 1), ValueError),
        ("edge_starts", lambda a: a[1:], ValueError),
        ("edge_starts", lambda a: changed(a, 0, -1), ValueError),
        ("trees_evaluated", lambda _: 0, ValueError),
        ("trees_evaluated", lambda _: 9, ValueError),
    ],
)
def test_arrays_that_are_no_forest_are_refused_by_name(forest, name, change, error):
    with pytest.raises(error, match=name):
        replace(forest, **{name: change(getattr(forest, name))})


def test_edges_in_the_middle_of_a_tree_are_refused(forest):
    starts = forest.edge_starts.copy()
    starts[1 : np.flatnonzero(forest.left_children == 0)[0] + 1] = 1
    with pytest.raises(ValueError, match="edge_starts"):
        replace(forest, edge_starts=starts)


def test_random_damage_of_a_model_file_is_refused_or_does_no_harm(forest, tmp_path):
    memory = io.BytesIO()
    forest.save(memory)
    content = bytearray(memory.getvalue())
    random = np.random.default_rng(0)
    told = 0
    for _ in range(300):
        damaged = content.copy()
        for place in random.integers(len(damaged), size=4):
            damaged[place] ^= int(random.integers(1, 256))
        told += not intact(bytes(damaged), forest)
    assert told > 250


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"no archive at all", b"\x93NUMPY\x01\x00"])
def test_other_files_are_refused_by_name(tmp_path, content):
    (tmp_path / "other.npz").write_bytes(content)
    with pytest.raises(ValueError, match=r"other\.npz"):
        StructuredForest.load(tmp_path / "other.npz")


def test_a_truncated_file_a_bare_array_and_another_format_are_refused(forest, tmp_path):
    path = tmp_path / "forest.npz"
    forest.save(path)
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(ValueError, match="intact"):
        StructuredForest.load(path)
    with path.open("wb") as file:
        np.save(file, np.arange(5))
    with pytest.raises(ValueError, match="intact"):
        StructuredForest.load(path)
    arrays = {field.name: getattr(forest, field.name) for field in fields(forest)}
    np.savez(path, **(arrays | {"trees_evaluated": np.int32(4), "format": np.int32(99)}))
    with pytest.raises(ValueError, match="format 99"):
        StructuredForest.load(path)
    for wrong in ({"format": np.ones(2, np.int32)}, {"trees_evaluated": np.float64(4)}):
        np.savez(path, **(arrays | {"trees_evaluated": np.int32(4), "format": np.int32(1)} | wrong))
        with pytest.raises(ValueError, match="its numbers are no numbers"):
            StructuredForest.load(path)
    with pytest.raises(FileNotFoundError):
        StructuredForest.load(tmp_path / "nothing.npz")


@pytest.mark.parametrize(
    ("found", "put", "said"),
    [
        ("stride: 2", "stride: 4", "stride is 4"),
        ("numberOfTrees: 8", "numberOfTrees: 7", "trees"),
        ("numberOfTreesToEvaluate: 4", "numberOfTreesToEvaluate: 0", "trees_evaluated"),
        ("featureIds:", "features:", "featureIds"),
        ("childs:\n   - [ 2,", "childs:\n   - [ 99999,", "outside"),
        ("childs:\n   - [ 2,", "childs:\n   - [ 1,", "outside"),
        ("childs:\n   - [ 2,", "childs:\n   - [ 2.5,", "whole number"),
        ("childs:\n   - [ 2,", "childs:\n   - [ two,", "two"),
        ("childs:\n   - [ 2, 4", "childs:\n   - [ 2, 2", "two ways"),
        ("edgeBoundaries:\n   - [ 0,", "edgeBoundaries:\n   - [ 999999,", "edgeBoundaries"),
        ("edgeBins:\n   - [ ", "edgeBins:\n   - [ 999, ", "edgeBins"),
    ],
)
def test_a_damaged_file_of_opencv_is_refused(forest, tmp_path, found, put, said):
    write_opencv(forest, tmp_path / "forest.yml")
    text = (tmp_path / "forest.yml").read_text()
    assert text.count(found) == 1
    (tmp_path / "damaged.yml").write_text(text.replace(found, put))
    with pytest.raises(ValueError, match=said):
        read_opencv(tmp_path / "damaged.yml")


@pytest.mark.parametrize("content", [b"", b"\x1f\x8bnot gzip", b"\xff\xfe\x00", b"options:\n"])
def test_what_is_no_forest_of_opencv_is_refused(tmp_path, content):
    (tmp_path / "other.yml").write_bytes(content)
    with pytest.raises(ValueError, match=r"other\.yml"):
        read_opencv(tmp_path / "other.yml")
