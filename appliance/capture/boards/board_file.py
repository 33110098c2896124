"""`board.json` of a rig folder: what is told on the command line goes into it, what stands in it counts."""

import json
from pathlib import Path

from appliance.capture.error import CaptureError
from appliance.capture.picture_writer import write_document
from vision.calibration.checkerboard import Board

BOARD_FILE = "board.json"


def board_of(folder: Path, told: dict[str, object]) -> Board:
    """Board of a rig folder; its `board.json` is written where it is new or where more is told now.

    Parameters
    ----------
    folder : Path
    told : dict
        Values of the command line by their key in `board.json`; None for what was not given.

    Raises
    ------
    CaptureError
        Squares or their side are told by nobody, or are no board's, or `board.json` says otherwise.
    """
    path = folder / BOARD_FILE
    stored = _read(path)
    given = {key: value for key, value in told.items() if value is not None}
    for key in ("squares", "square_mm"):
        if key in stored and key in given and stored[key] != given[key]:
            raise CaptureError(f"{path}: {key} is {stored[key]} there, and {given[key]} now; give a new folder")
    document = stored | given
    missing = [key for key in ("squares", "square_mm") if key not in document]
    if missing:
        raise CaptureError(f"{path}: {' and '.join(missing)} are not known; give --squares 8x5 --mm 50, as printed")
    try:
        board = Board.from_json(json.dumps(document))
    except ValueError as error:
        raise CaptureError(f"{path}: {error}") from error
    if document != stored:
        write_document(path, document)
    return board


def _read(path: Path) -> dict[str, object]:
    if not path.is_file():
        return {}
    try:
        stored: dict[str, object] = {**json.loads(path.read_text(encoding="utf-8"))}
    except (OSError, ValueError, TypeError, RecursionError) as error:
        raise CaptureError(f"{path}: not a readable JSON object ({error}); correct it or remove it") from error
    return stored
