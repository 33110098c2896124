"""`orient`: rows per frame and per ingot, and its refusals."""

import csv
import json

import cv2
import pytest
from ingot_recording import BOTTOM, EMPTY, write_recording

from appliance.cli.main import main
from appliance.ingot.annotated_pictures import COLOURS, LEGEND_PX

FRAME_KEYS = [
    "frame", "present", "orientation", "ssim_top", "ssim_bottom", "center_x", "center_y", "radius", "reasons",
]  # fmt: skip
INGOT_KEYS = ["ingot", "orientation", "first_frame", "decided_frame", "confidence"]


@pytest.fixture(scope="module")
def recording(recordings, tmp_path_factory):
    folder = tmp_path_factory.mktemp("orient") / "line"
    return write_recording(folder, recordings / "ingot_line", EMPTY, BOTTOM)


def orient(recording, references, output, *more):
    words = ["orient", recording, "--references", references, "--output", output, *more]
    return main([str(word) for word in words])


def rows(file):
    return [json.loads(line) for line in file.read_text().splitlines()]


def test_every_frame_and_every_ingot_is_a_row_with_the_agreed_keys(recording, recordings, tmp_path):
    assert orient(recording, recordings / "ingot_line", tmp_path / "out.jsonl") == 0
    lines = rows(tmp_path / "out.jsonl")
    frames = [line for line in lines if "frame" in line]
    assert [line["frame"] for line in frames] == list(range(len(list(recording.iterdir()))))
    assert all(list(line) == FRAME_KEYS for line in frames)
    assert frames[0] == dict.fromkeys(FRAME_KEYS) | {
        "frame": 0,
        "present": False,
        "orientation": "undecided",
        "reasons": ["nothing_hot"],
    }
    (ingot,) = (line for line in lines if "ingot" in line)
    assert list(ingot) == INGOT_KEYS
    assert (ingot["ingot"], ingot["orientation"]) == (1, "bottom")
    assert lines[lines.index(ingot) - 1]["frame"] == ingot["decided_frame"], "told as soon as it is decided"
    assert frames[ingot["first_frame"]]["present"]
    assert not frames[ingot["first_frame"] - 1]["present"]


def test_csv_has_the_same_rows_as_json_lines_frames_and_ingots_each_in_a_file(recording, recordings, tmp_path, capsys):
    for name in ("out.jsonl", "out.csv"):
        orient(recording, recordings / "ingot_line", tmp_path / name)
    assert "  1 ingots: 0 top, 1 bottom, 0 undecided" in capsys.readouterr().out
    for name, key, keys in (("out.csv", "frame", FRAME_KEYS), ("out-ingots.csv", "ingot", INGOT_KEYS)):
        with (tmp_path / name).open(newline="") as file:
            lines = list(csv.DictReader(file))
        wanted = [row for row in rows(tmp_path / "out.jsonl") if key in row]
        assert list(lines[0]) == keys
        for ours, theirs in zip(lines, wanted, strict=True):
            for column, value in theirs.items():
                text = ";".join(value) if isinstance(value, list) else "" if value is None else str(value)
                assert ours[column] == (text.lower() if isinstance(value, bool) else text)


def test_ingots_in_csv_replace_no_file_that_is_read(recording, recordings, tmp_path, capsys):
    references = tmp_path / "references-ingots.csv"
    references.mkdir()
    assert orient(recording, references, tmp_path / "references.csv") == 2
    assert "would be lost" in capsys.readouterr().err


def test_the_sources_classifiers_can_be_chosen(recording, recordings, tmp_path):
    for classifier in ("single", "dual"):
        assert orient(recording, recordings / "ingot_line", tmp_path / "out", "--classifier", classifier) == 0
        for line in rows(tmp_path / "out"):
            if line.get("present"):
                top = line["ssim_top"] > 0.75 if classifier == "single" else line["ssim_top"] >= line["ssim_bottom"]
                assert line["orientation"] == ("top" if top else "bottom")


def test_plot_writes_a_picture_per_frame_and_a_strip_of_the_ends(recording, recordings, tmp_path):
    assert orient(recording, recordings / "ingot_line", tmp_path / "out", "--plot", tmp_path / "plot") == 0
    found = sum(bool(line.get("present")) for line in rows(tmp_path / "out"))
    assert len(list((tmp_path / "plot").glob("*.jpg"))) == len(list(recording.iterdir()))
    strip = cv2.imread(str(tmp_path / "plot" / "ends.png"))
    assert strip.shape == (-(-found // 12) * 70 + LEGEND_PX, 12 * 70, 3)
    legend = {tuple(map(int, colour)) for colour in strip[-LEGEND_PX:].reshape(-1, 3)}
    assert set(COLOURS.values()) <= legend


def test_trouble_is_one_sentence_and_leaves_no_file(recording, recordings, tmp_path, capsys):
    references = recordings / "ingot_line"
    bad = tmp_path / "bad"
    bad.mkdir()
    for name in ("top.png", "bottom.png"):
        (bad / name).write_bytes((references / name).read_bytes())
    (bad / "roi.json").write_text('{"roi_crop": [800, 100, 300, 300], "roi_centroid": [0, 0, 9, 9]}')
    settings = tmp_path / "limits.toml"
    settings.write_text("[ingot.limits]\nradius_min_px = 50\nradius_max_px = 40\n")
    for words, said in (
        ((tmp_path / "absent", references), "no such folder"),
        ((recording, tmp_path), "references are top.png and bottom.png"),
        ((recording, bad), "does not lie in pictures of 960 x 540"),
        ((recording, references, "--config", settings), "radius_px"),
    ):
        assert orient(*words[:2], tmp_path / "out", *words[2:]) == 2
        sentence = capsys.readouterr().err
        assert said in sentence
        assert sentence.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.fixture
def references(recordings, tmp_path):
    """Our own copy of the references: learning writes beside them."""
    for name in ("top.png", "bottom.png", "roi.json"):
        (tmp_path / name).write_bytes((recordings / "ingot_line" / name).read_bytes())
    return tmp_path


def test_learning_from_one_ingot_says_that_it_is_too_little_and_keeps_the_end_for_the_next(
    recording, references, capsys
):
    before = {path.name: path.read_bytes() for path in references.iterdir()}
    for kept in (1, 2):
        assert orient(recording, references, references / "out.jsonl", "--learn", "bottom") == 0
        assert f"0 references learned; 0 confirmed tops and {kept} bottoms are kept (at" in capsys.readouterr().out
    assert {name: (references / name).read_bytes() for name in before} == before
    assert [path.name for path in (references / "learned").iterdir()] == ["confirmed.npz"]
    assert orient(recording, references, references / "out.jsonl", "--use", 0, "--learn", "bottom") == 0
    assert "0 confirmed tops and 1 bottoms" in capsys.readouterr().out


def test_confirmed_ends_that_cannot_be_read_are_told_in_a_sentence(recording, references, capsys):
    (references / "learned").mkdir()
    (references / "learned" / "confirmed.npz").write_bytes(b"PK no archive")
    assert orient(recording, references, references / "out.jsonl", "--learn") == 2
    assert "confirmed.npz: no confirmed ends in it; delete the file" in capsys.readouterr().err


def test_a_pair_that_nobody_learned_cannot_be_used(recording, references, capsys):
    assert orient(recording, references, references / "out.jsonl", "--use", 3) == 2
    assert "learned: there is no pair 3; learned are none, 0 is the commissioned one" in capsys.readouterr().err
