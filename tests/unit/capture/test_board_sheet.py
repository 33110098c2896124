"""The printed board is as large as it says, and so are its rulers: measured on the page as a printer would draw it."""

import shutil
import subprocess

import cv2
import numpy as np
import pytest

from appliance.capture.boards.sheet import RULER_STEP_MM, sheet_of
from appliance.cli.main import main

DPI = 127  # 5 pixels a millimetre
PX_PER_MM = DPI / 25.4


def page_of(folder, squares, mm):
    output = folder / "board.pdf"
    assert main(["board", "--squares", squares, "--mm", str(mm), "--output", str(output)]) == 0
    assert shutil.which("pdftoppm"), "pdftoppm is missing; install the Debian package poppler-utils"
    subprocess.run(["pdftoppm", "-r", str(DPI), "-gray", "-singlefile", output, folder / "page"], check=True)
    return cv2.imread(str(folder / "page.pgm"), cv2.IMREAD_GRAYSCALE)


def dark_run_px(line):
    """Length from the first dark pixel to the last, in pixels."""
    dark = np.flatnonzero(line < 128)
    return dark[-1] - dark[0] + 1


def test_squares_and_rulers_measure_what_they_say(tmp_path):
    page = page_of(tmp_path, "7x5", 30)
    found, corners = cv2.findChessboardCorners(page, (6, 4))
    assert found
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-4)
    grid = cv2.cornerSubPix(page, corners, (11, 11), (-1, -1), criteria).reshape(4, 6, 2)
    along_mm = np.linalg.norm(grid[:, -1] - grid[:, 0], axis=1) / PX_PER_MM
    down_mm = np.linalg.norm(grid[-1] - grid[0], axis=1) / PX_PER_MM
    assert along_mm == pytest.approx(150, rel=3e-4)
    assert down_mm == pytest.approx(90, rel=3e-4)
    sheet = sheet_of((7, 5), 30.0)
    below = page[round((sheet.height_mm - 20) * PX_PER_MM) :]
    beside = page[:, : round(20 * PX_PER_MM)]
    ruler = max(dark_run_px(row) for row in below[: round(4 * PX_PER_MM)] if (row < 128).mean() > 0.2)
    upright = max(dark_run_px(row) for row in beside.T if (row < 128).mean() > 0.2)
    assert ruler / PX_PER_MM == pytest.approx(210, abs=0.5)
    assert upright / PX_PER_MM == pytest.approx(150, abs=0.5)


@pytest.mark.parametrize(("squares", "mm"), [((8, 5), 2.0), ((8, 5), 23.9), ((8, 5), 50.0), ((30, 20), 60.0)])
def test_a_sheet_holds_the_board_its_white_margin_and_its_rulers(squares, mm):
    sheet = sheet_of(squares, mm)
    assert sheet.left_mm >= mm + 5
    assert sheet.top_mm >= mm + 5
    for ruler_mm, count in zip(sheet.rulers_mm, squares, strict=True):
        assert count * mm - RULER_STEP_MM < ruler_mm <= count * mm


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--squares", "8"], "is no number of squares; give it as 8x5"),
        (["--squares", "3x3"], "at least 4 along one of them, such as 8x5"),
        (["--squares", "8x2"], "give 3 to 100 squares along a side"),
        (["--mm", "0"], "give the side of a square, 2 to 1000 mm"),
        (["--mm", "nan"], "give the side of a square, 2 to 1000 mm"),
        (["--squares", "90x80", "--mm", "100"], "the sheet would be 9210 mm wide"),
        (["--output", "board.docx"], "give a name that ends in .pdf"),
        (["--output", "nowhere/board.pdf"], "No such file or directory; give a place in a writable folder"),
    ],
)
def test_a_board_that_cannot_be_printed_is_one_sentence(words, said, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    try:
        code = main(["board", *words])
    except SystemExit as end:
        code = end.code
    assert code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert not list(tmp_path.iterdir())
