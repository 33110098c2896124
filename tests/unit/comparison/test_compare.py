"""`compare`: figures of known errors, tables of ends that are counted by hand, and one sentence for trouble."""

import json
import math

import numpy as np
import pytest

from appliance.cli.main import main
from appliance.comparison.ends import compared_ends
from appliance.comparison.files import EndTruth, read_rows, read_truth
from appliance.comparison.sizes import Sizes, compared, share_interval
from appliance.files.row_writer import row_writer

SPOILT = {
    "deep": "[" * 100_000,
    "text": '{"frame": 0, "diameter_mm": "x"}',
    "huge": json.dumps({"frame": 0, "diameter_mm": 10**400}),
    "frames": '{"frame": [0], "diameter_mm": 1}',
    "half": '{"frame": 0, "ssim_top": 0.5}',
    "word": '{"frame": 0, "ssim_top": 0.5, "present": true, "orientation": "left"}',
}
ERRORS_MM = [0.10, -0.20, 0.30, 0.0, -1.5]


def reading(frame, diameter_mm, expanded_mm=0.25, **more):
    values = {"diameter_mm": diameter_mm, "expanded_uncertainty_mm": expanded_mm, "valid": diameter_mm is not None}
    return {"frame": frame} | values | {"diameter_virtual_board_mm": None, "reasons": []} | more


@pytest.fixture
def files(tmp_path):
    """Five values of a bar of 100 mm, one frame without a value, one without a bar, and one with a value and no bar."""
    rows = [reading(frame, 100 + error) for frame, error in enumerate(ERRORS_MM)]
    rows += [reading(5, None, None), reading(6, None, None), reading(7, 55.0)]
    truth = {
        "diameter_mm": 100.0,
        "frames": [{"frame": f"{frame:06}"} for frame in range(6)]
        + [{"frame": "000006", "diameter_mm": None}, {"frame": "000007", "empty": True}],
    }
    (tmp_path / "readings.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    (tmp_path / "truth.json").write_text(json.dumps(truth))
    return tmp_path


def test_figures_of_diameters_are_those_that_a_hand_would_compute(files):
    found = compared(Sizes.of(read_rows(files / "readings.jsonl"), read_truth(files)))
    assert (found.measurable, found.empty, found.values_without_bar) == (6, 2, 1)
    assert found.availability == pytest.approx(5 / 6)
    assert found.errors.bias_mm == pytest.approx(np.mean(ERRORS_MM))
    assert found.errors.bias_error_mm == pytest.approx(np.std(ERRORS_MM, ddof=1) / math.sqrt(5))
    assert found.errors.rmse_mm == pytest.approx(np.sqrt(np.mean(np.square(ERRORS_MM))))
    assert (found.errors.worst_mm, found.errors.worst_frame) == (pytest.approx(-1.5), 4)
    assert (found.covered, found.stated, found.wrong) == (3, 5, 1)
    assert found.coverage == pytest.approx(0.6)
    assert found.virtual_board_errors.values == 0


def test_bars_side_by_side_are_not_counted_against_one_truth(files, capsys):
    with (files / "readings.jsonl").open("a") as file:
        file.write(json.dumps(reading(3, 140.0, bar=1)) + "\n")
    assert main(["compare", str(files / "readings.jsonl"), str(files)]) == 2
    assert "frame 3 has readings of 2 bars" in capsys.readouterr().err


def test_wilson_s_interval_is_that_of_the_textbooks():
    assert share_interval(8, 10) == pytest.approx((0.4902, 0.9433), abs=1e-4)  # Agresti and Coull, 1998
    assert all(math.isnan(end) for end in share_interval(0, 0))


def test_csv_says_the_same_as_json_lines(files, capsys):
    rows = read_rows(files / "readings.jsonl")
    with (files / "readings.csv").open("w", encoding="utf-8", newline="") as file:
        write = row_writer(files / "readings.csv", file, list(rows[0]))
        for row in rows:
            write(row)
    for name in ("readings.jsonl", "readings.csv"):
        assert main(["compare", str(files / name), str(files)]) == 0
    first, second = np.array_split(capsys.readouterr().out.splitlines(), 2)
    assert first.tolist() == second.tolist()
    assert first[1] == "availability    83.3 % (5 of 6 got a value, and 1 values without a bar)"
    assert first[8].startswith("error within U  60.0 % (3 of 5; 95 % interval 23 to 88 %), mean U 0.250 mm")


def end(frame, orientation, ssim_top=0.8, *, present=True):
    return {"frame": frame, "present": present, "orientation": orientation, "ssim_top": ssim_top, "ssim_bottom": 0.5}


def truth_of_ends():
    """A top in frames 3 to 8, nothing, a bottom in frames 20 to 25."""
    placed = {frame: EndTruth(True, "top", "placed") for frame in range(3, 9)}
    placed |= {frame: EndTruth(True, "bottom", "placed") for frame in range(20, 26)}
    return {frame: EndTruth(False, "", "empty") for frame in range(30)} | placed


def test_verdicts_and_decisions_are_counted_against_the_truth():
    rows = [end(frame, "top", 0.8) for frame in range(3, 8)] + [end(8, "bottom", 0.6)]
    rows += [end(frame, "bottom", 0.7) for frame in range(20, 25)] + [end(25, "bottom", present=False)]
    rows += [end(12, "top")]
    rows += [
        {"ingot": 1, "orientation": "top", "first_frame": 3, "decided_frame": 6},
        {"ingot": 2, "orientation": "top", "first_frame": 20, "decided_frame": 24},
        {"ingot": 3, "orientation": "bottom", "first_frame": 29, "decided_frame": 29},
    ]
    found = compared_ends(rows, truth_of_ends())
    counts = found.confusion
    assert (found.placed, found.found, found.found_elsewhere) == (12, 11, 1)
    assert (counts.top_as_top, counts.top_as_bottom, counts.bottom_as_bottom) == (5, 1, 5)
    assert counts.precision("top") == 1.0
    assert counts.recall("top") == pytest.approx(5 / 6)
    assert counts.accuracy == pytest.approx(10 / 11)
    assert [tuple(one) for one in found.ingots] == [("top", "top", 4), ("bottom", "top", 5)]
    assert [one.first_frame for one in found.strangers] == [29]
    similar = found.similarities["top"]
    assert (similar.count, similar.largest, similar.least) == (6, 0.8, 0.6)
    assert similar.mean == pytest.approx((5 * 0.8 + 0.6) / 6)


def test_of_csv_the_file_of_ingots_beside_it_belongs_to_it(files, capsys):
    lines = ["frame,present,label,x,y,r,state,touch,over"]
    lines += [f"{frame},{int(one.present)},{one.label},,,,{one.state},0,0" for frame, one in truth_of_ends().items()]
    (files / "truth.csv").write_text("\n".join(lines))
    names = ("frame", "present", "orientation", "ssim_top", "ssim_bottom")
    rows = [",".join(str(end(frame, "top")[name]).lower() for name in names) for frame in range(3, 9)]
    (files / "ends.csv").write_text("\n".join([",".join(names), *rows]))
    (files / "ends-ingots.csv").write_text("ingot,orientation,first_frame,decided_frame,confidence\n1,top,3,6,99.9\n")
    assert main(["compare", str(files / "ends.csv"), str(files / "truth.csv")]) == 0
    assert "ingots          1 of 2 right, 1 undecided" in capsys.readouterr().out
    (files / "ends-ingots.csv").write_text("ingot,orientation,first_frame,decided_frame,confidence\n")
    assert main(["compare", str(files / "ends.csv"), str(files / "truth.csv")]) == 0
    assert "ingots          0 of 2 right, 2 undecided" in capsys.readouterr().out


def test_files_that_a_spreadsheet_has_saved_again_are_read(files, capsys):
    """With a byte-order mark, Windows line ends, and cells behind the last heading."""
    rows = ["frame,diameter_mm,expanded_uncertainty_mm,valid", "0,100.1,0.25,true,,", "1,99.8,0.25,true,,"]
    (files / "readings.csv").write_bytes("\r\n".join(rows).encode("utf-8-sig"))
    (files / "truth.json").write_bytes(b"\xef\xbb\xbf" + (files / "truth.json").read_bytes())
    assert main(["compare", str(files / "readings.csv"), str(files)]) == 0
    assert "2 of 2 got a value" in capsys.readouterr().out


def test_plots_of_both_kinds_are_drawn(files, capsys):
    assert main(["compare", str(files / "readings.jsonl"), str(files), "--plot", str(files / "sizes.png")]) == 0
    (files / "ends.jsonl").write_text("\n".join(json.dumps(end(frame, "top")) for frame in range(3, 9)))
    lines = ["frame,present,label,x,y,r,state,touch,over"]
    lines += [f"{frame},{int(one.present)},{one.label},,,,{one.state},0,0" for frame, one in truth_of_ends().items()]
    (files / "truth.csv").write_text("\n".join(lines))
    words = ["compare", str(files / "ends.jsonl"), str(files / "truth.csv"), "--plot", str(files / "ends.svg")]
    assert main(words) == 0
    assert "6 with an ingot on the line; end found in 6, and in 0 without" in capsys.readouterr().out
    assert min((files / name).stat().st_size for name in ("sizes.png", "ends.svg")) > 10_000


@pytest.mark.parametrize(
    ("readings", "truth", "said"),
    [
        ("nothing.jsonl", "truth.json", "nothing.jsonl: cannot be read (No such file or directory)"),
        ("truth.json", "truth.json", "truth.json: shares no frame with"),
        ("readings.jsonl", "nowhere", "nowhere: cannot be read"),
        ("readings.jsonl", "readings.jsonl", "readings.jsonl: is no truth"),
        ("readings.jsonl", "empty", "empty: has neither truth.json nor truth.csv; give a recording"),
        ("readings.jsonl", "other.json", "other.json: shares no frame with"),
        ("readings.jsonl", "ends.csv", "readings.jsonl are readings of bars, "),
        ("deep.jsonl", "truth.json", "deep.jsonl: is neither CSV nor JSON lines of readings"),
        (
            "text.jsonl",
            "truth.json",
            "text.jsonl: is neither CSV nor JSON lines of readings (row 1: diameter_mm is 'x')",
        ),
        ("huge.jsonl", "truth.json", "(row 1: diameter_mm is 1000000000"),
        ("frames.jsonl", "truth.json", "(row 1: frame is [0])"),
        ("half.jsonl", "ends.csv", "(row 1: present is missing)"),
        ("word.jsonl", "ends.csv", "(row 1: orientation is 'left')"),
        ("readings.jsonl", "deep.jsonl", "deep.jsonl: is no truth"),
        ("readings.jsonl", "huge.json", "huge.json: is no truth"),
        ("readings.jsonl", "label.csv", "label.csv: is no truth (frame 0 has the label 'side')"),
        ("readings.jsonl", "truth.json --plot x.gif", "--plot: x.gif is no picture; let its name end in .png, "),
    ],
)
def test_trouble_is_one_sentence(files, capsys, readings, truth, said):
    (files / "empty").mkdir()
    (files / "other.json").write_text('{"frames": [{"frame": "000099", "diameter_mm": 10.0}]}')
    (files / "ends.csv").write_text("frame,present,label,state\n0,1,top,placed\n")
    (files / "label.csv").write_text("frame,present,label,state\n0,1,side,placed\n")
    (files / "huge.json").write_text(json.dumps({"frames": [{"frame": 0, "diameter_mm": 10**400}]}))
    for kind, text in SPOILT.items():
        (files / f"{kind}.jsonl").write_text(text)
    name, *more = truth.split()
    assert main(["compare", str(files / readings), str(files / name), *more]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("hotgauge: ")
    assert err.count("\n") == 1
    assert said in err
