"""Code values and codings that a recording keeps beside the pictures that people see.

`measured/codings.json` holds the coding of each picture that is not plain, by the name of its frame, left first;
`measured/left/000000.png` holds the code values that were measured where they are not those of the frame's own file.
The black box and `hotgauge capture` write them, so that pictures which came as JPEG or video are measured again as they
were sent.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from appliance.cameras.recording.picture_file import read_picture
from appliance.cameras.source import CameraError
from vision.sent_picture import Coding, SentPicture, sent_picture

MEASURED_FOLDER = "measured"
CODINGS_FILE = "codings.json"
PLAIN_CODINGS = (Coding("grey"), Coding("colour"))


def codings_document(codings: Mapping[str, Sequence[Coding]]) -> bytes:
    """Content of `codings.json`: the codings of frames by their names, left first."""
    return json.dumps({name: [asdict(one) for one in both] for name, both in codings.items()}, indent=1).encode()


class StoredCodings:
    """The codings of a recording's pictures.

    Parameters
    ----------
    folder : Path
        Of the recording.

    Raises
    ------
    CameraError
        The file of codings cannot be read or says something else.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder / MEASURED_FOLDER
        self._codings: dict[str, list[Coding]] = {}
        path = self._folder / CODINGS_FILE
        if not path.is_file():
            return
        try:
            told: dict[str, list[dict[str, Any]]] = json.loads(path.read_text(encoding="utf-8"))
            self._codings = {name: [_coding(one) for one in both] for name, both in told.items()}
        except (OSError, ValueError, AttributeError, TypeError, KeyError) as error:
            raise CameraError(f"{path}: no codings of pictures ({error!r}); copy the recording again") from error

    def of(self, picture: SentPicture, name: str, side: str, index: int) -> SentPicture:
        """A picture with the coding and the code values that are stored for it.

        Parameters
        ----------
        picture : SentPicture
            As its own file says; its code values are kept unless others are stored.
        name : str
            Of its frame.
        side : str
            Folder of its camera.
        index : int
            0 for left, 1 for right.

        Raises
        ------
        CameraError
            The stored code values cannot be read, or do not fit.
        """
        if name not in self._codings:
            return picture
        path = self._folder / side / f"{name}.png"
        stored = read_picture(path) if path.is_file() else picture
        if stored.size != picture.size:
            raise CameraError(f"{path}: of another size than what is shown; copy the recording again")
        codes = stored.measured if stored.measured.shape[2] == 3 else stored.measured[:, :, 0]
        try:
            return sent_picture(codes, self._codings[name][index], picture.shown)
        except (ValueError, IndexError) as error:
            raise CameraError(f"{path}: {error}; copy the recording again") from error


def _coding(told: dict[str, Any]) -> Coding:
    red, blue = told.pop("luma_weights")
    return Coding(luma_weights=(float(red), float(blue)), **told)
