"""An archive is measured whole: each recording once, whatever ends on the way, and to the bits of a single process."""

import argparse
import json
import os
import shutil
from functools import partial
from pathlib import Path

import cv2
import pyarrow.parquet as pq
import pytest
from archive_workers import FRAMES, counted, ends_always, ends_once, refuses

from appliance.archives.measure_archive import measure_archive
from appliance.archives.recordings import ArchiveError, find_recordings
from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.cli.main import main
from appliance.cli.pictures.archive import deciding_options, measure_one
from appliance.sizing.reading_rows import COLUMNS
from appliance.sizing.stereo.rig_file import save_rig

SIDES = ("left", "right")
NAMES = ("a/first", "a/second", "third")


@pytest.fixture(scope="module")
def archive(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("archive")
    save_rig(mill_rig(MillSource(seed=1, rate_hz=0)), folder / "rig.json")
    with MillSource(seed=1, rate_hz=0) as source:
        for name in NAMES:
            for number in range(FRAMES):
                pair = source.next(10)
                for side, picture in zip(SIDES, (pair.left, pair.right), strict=True):
                    place = folder / "archive" / name / side
                    place.mkdir(parents=True, exist_ok=True)
                    cv2.imwrite(str(place / f"{number:06}.png"), picture)
    return folder


def run(archive: Path, output: Path, measure, options=None):
    return measure_archive(
        archive / "archive",
        output,
        partial(measure, log=output.with_suffix(".log")),
        options or {"rig": "x"},
        columns=COLUMNS,
        processes=2,
        dask=None,
        show=lambda *_: None,
    )


def names(output: Path) -> list[str]:
    return pq.read_table(output).column("recording").to_pylist()


def test_recordings_are_found_at_any_depth_and_what_lies_in_one_is_no_other(archive, tmp_path):
    found = [str(one.relative_to(archive / "archive")) for one in find_recordings(archive / "archive")]
    assert found == list(NAMES)
    (tmp_path / "one").mkdir()
    (tmp_path / "one/000000.jpg").touch()
    (tmp_path / "one/scale").mkdir()
    (tmp_path / "one/scale/000000.png").touch()
    (tmp_path / "films").mkdir()
    for side in SIDES:
        (tmp_path / "films" / f"{side}.mp4").touch()
    assert [one.name for one in find_recordings(tmp_path)] == ["films", "one"]


@pytest.mark.parametrize("inside", ["", "no/pictures"])
def test_an_archive_without_recordings_is_refused(tmp_path, inside):
    (tmp_path / inside).mkdir(parents=True, exist_ok=True)
    with pytest.raises(ArchiveError, match="no recordings in it"):
        find_recordings(tmp_path)


def test_a_killed_worker_loses_nothing_and_nothing_is_there_twice(archive, tmp_path):
    found = run(archive, tmp_path / "all.parquet", ends_once)
    assert (found.recordings, found.frames, found.failed) == (3, 3 * FRAMES, {})
    assert names(tmp_path / "all.parquet") == [name for name in NAMES for _ in range(FRAMES)]
    assert not (tmp_path / "all.parquet.parts").exists()


def test_a_recording_that_ends_every_worker_is_named_and_the_others_are_measured(archive, tmp_path):
    found = run(archive, tmp_path / "all.parquet", ends_always)
    assert list(found.failed) == ["a/second"]
    assert found.frames == 2 * FRAMES
    rows = pq.read_table(tmp_path / "all.parquet").to_pylist()
    assert [row["recording"] for row in rows if row["error"]] == ["a/second"]


def test_what_was_measured_before_is_not_measured_again_but_what_failed_is(archive, tmp_path):
    output = tmp_path / "all.parquet"
    log = output.with_suffix(".log")
    first = run(archive, output, refuses)
    assert list(first.failed) == ["a/second"]
    log.unlink()
    again = run(archive, output, counted)
    assert (again.resumed, again.failed, again.frames) == (2, {}, 3 * FRAMES)
    assert log.read_text().split() == ["second"]


@pytest.mark.parametrize("change", ["options", "picture"])
def test_what_was_measured_otherwise_or_has_changed_is_measured_again(archive, tmp_path, change):
    output = tmp_path / "all.parquet"
    copy = tmp_path / "copy"
    shutil.copytree(archive, copy)
    run(copy, output, refuses)
    if change == "picture":
        os.utime(copy / "archive/third/left/000000.png", (1, 1))
    again = run(copy, output, counted, {"rig": "y" if change == "options" else "x"})
    assert again.resumed == (0 if change == "options" else 1)


def test_an_archive_gives_the_bits_of_its_recordings_measured_alone(archive, tmp_path):
    output = tmp_path / "all.parquet"
    words = ["measure", str(archive / "archive"), "--rig", str(archive / "rig.json"), "--output", str(output)]
    assert main([*words, "--processes", "2"]) == 0
    rows = pq.read_table(output).to_pylist()
    assert len(rows) == len(NAMES) * FRAMES
    for name in NAMES[:1]:
        single = tmp_path / "single.jsonl"
        recording = str(archive / "archive" / name)
        assert main(["measure", recording, "--rig", str(archive / "rig.json"), "--output", str(single)]) == 0
        alone = [json.loads(line) for line in single.read_text().splitlines()]
        together = [row for row in rows if row["recording"] == name]
        for one, other in zip(alone, together, strict=True):
            assert all(one[column] == other[column] for column in COLUMNS if column != "elapsed_ms")


def test_a_wrong_command_line_is_refused_once_and_not_for_each_recording(archive, tmp_path, capsys):
    output = str(tmp_path / "all.parquet")
    assert main(["measure", str(archive / "archive"), "--output", output, "--processes", "1"]) == 2
    assert "--rig" in capsys.readouterr().err
    assert main(["measure", str(archive / "archive"), "--output", "all.csv", "--processes", "2"]) == 2
    assert ".parquet" in capsys.readouterr().err


def test_a_file_that_an_option_names_counts_by_its_content(tmp_path):
    forest = tmp_path / "edges.npz"
    given = argparse.Namespace(recording=tmp_path, output=tmp_path / "all.parquet", edge_model=forest, edges="forest")
    kept = []
    for content in (b"one", b"another"):
        forest.write_bytes(content)
        kept.append(deciding_options(given))
    assert kept[0] != kept[1]
    assert {"recording", "output"}.isdisjoint(kept[0])


def test_a_recording_whose_files_give_way_is_a_row_that_says_why(tmp_path):
    def fails(_):
        raise OSError(5, "Input/output error", "000003.png")

    (row,) = measure_one(argparse.Namespace(), fails, tmp_path)
    assert row["frame"] is None
    assert "000003.png" in row["error"]
