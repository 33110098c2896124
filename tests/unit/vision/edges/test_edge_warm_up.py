"""Kernels are compiled once and kept where the service may write; nothing compiles in a measured frame."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba.core import event
from random_forests import random_picture

import vision.edges.thinning
from vision.edges.forest.inference import shipped_detector
from vision.edges.operators import detect_edges
from vision.edges.thinning import ridges

SMALL_KERNEL = """
import numpy as np
from numba.core import event
from {module} import ridges
with event.install_recorder("numba:compile") as recorder:
    ridges(np.zeros((8, 8), np.float32), np.zeros((8, 8), np.float32))
print(sum(entry.is_start for _, entry in recorder.buffer))
"""


def warm_up():
    """Compile every kernel of the edge forest and of thinning, or read it from the cache on disk."""
    edges = detect_edges(np.zeros((64, 64), np.float32), "forest")
    ridges(edges.strength, edges.normal_rad)


def compilations(module, folder, **environment):
    """How many kernels a fresh process compiles for one small call."""
    kept = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    done = subprocess.run(
        [sys.executable, "-c", SMALL_KERNEL.format(module=module)],
        cwd=folder,
        env=kept | environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=120,
    )
    return int(done.stdout)


def test_after_warming_up_nothing_is_compiled():
    warm_up()
    with event.install_recorder("numba:compile") as recorder:
        for colours in (1, 3):
            picture = random_picture(90, 300, colours=colours)
            edges = detect_edges(picture, "forest")
            ridges(edges.strength, edges.normal_rad)
            shipped_detector().strength_in(picture, [np.s_[10:60, :], np.s_[:, 100:150], np.s_[20:40, 5:50]])
            shipped_detector().strength_in(picture[5:-3, ::-1], [np.s_[:, 20:]])
    assert not recorder.buffer


def test_the_cache_folder_may_be_chosen_and_is_used(tmp_path):
    repository = Path(__file__).parents[4]
    chosen = {"NUMBA_CACHE_DIR": str(tmp_path)}
    assert compilations("vision.edges.thinning", repository, **chosen) > 0
    assert list(tmp_path.rglob("*.nbc"))
    assert compilations("vision.edges.thinning", repository, **chosen) == 0


@pytest.fixture
def unwritable(tmp_path):
    """A module whose folder takes no cache: a file stands where the folder for it would be made."""
    folder = tmp_path / "package"
    folder.mkdir()
    shutil.copy(vision.edges.thinning.__file__, folder / "kernels.py")
    (folder / "__pycache__").write_text("in the way")
    return folder


def test_the_users_cache_serves_where_the_installation_cannot_be_written(unwritable, tmp_path):
    home = {"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    assert compilations("kernels", unwritable, **home) > 0
    assert list(tmp_path.rglob("*.nbc"))
    assert compilations("kernels", unwritable, **home) == 0
