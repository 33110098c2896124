"""Commissioning through the page: folders of board pictures, their calibration, verification and confirmation.

The work is done by the commands of `hotgauge`, in a process of low priority; the page itself loads no image library.
What was done stands in the folder, so that it goes on where it stopped, also after a restart of the page.
"""

import json
import logging
import shutil
import subprocess
import threading
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal, NamedTuple, cast

from appliance.errors import HotgaugeError
from appliance.files.atomic_file import whole_file, whole_place
from appliance.files.digest import file_sha256
from appliance.files.reload_request import ask_for_reload
from appliance.page.board_pictures import BoardPictures
from appliance.page.low_priority import low_priority_command

CANDIDATE = "rig_candidate.json"
STATE_FILE = "commissioning.json"
LOG_FILE = "commissioning.jsonl"
JOB_MAX_S = 1800.0  # chosen: a calibration of forty pairs of twelve megapixels takes some minutes

Step = Literal["calibrated", "verified"]
STEPS: tuple[Step, ...] = ("calibrated", "verified")

logger = logging.getLogger("hotgauge.page")


class CommissioningError(HotgaugeError):
    """A step cannot be done; the message says what, where and what to do."""


class Done(NamedTuple):
    """One step that was done.

    Attributes
    ----------
    ok : bool
    who : str
    when : str
        ISO 8601, local time.
    report : str
        What the command said.
    sha256 : str
        Of the rig file that it made or used.
    """

    ok: bool
    who: str
    when: str
    report: str
    sha256: str


class Commissioning:
    """Commissioning of the two sizing cameras.

    Parameters
    ----------
    folder : Path
        In it a folder for each set of board pictures, and for each recording of a master bar.
    rig : Path or None
        Rig file that the gauge uses (`sizing.rig`); None if the settings name none.
    config : Path or None
        Settings file, whose history keeps verifications.
    refusal : callable
        Says of the SHA-256 of a calibration why the settings, read again, do not permit it; empty if they do.
    """

    def __init__(self, folder: Path, rig: Path | None, config: Path | None, refusal: Callable[[str], str]) -> None:
        self.folder = folder
        self.rig = rig
        self._config = config
        self._refusal = refusal
        self.board_pictures = BoardPictures(folder, config)
        self._running: tuple[str, Step] | None = None
        self._one_at_a_time = threading.Lock()

    @property
    def running(self) -> tuple[str, Step] | None:
        """Name of the folder and step of the work that is being done."""
        return self._running

    def names(self, *, with_boards: bool) -> list[str]:
        """Folders with board pictures, or the others, which may be recordings.

        Parameters
        ----------
        with_boards : bool
        """
        if not self.folder.is_dir():
            return []
        found = sorted(path for path in self.folder.iterdir() if path.is_dir() and not path.is_symlink())
        return [path.name for path in found if (path / "calibration").is_dir() == with_boards]

    def steps(self, name: str) -> dict[str, Done]:
        """Steps that were done in a folder; a candidate that has changed since counts no more.

        Parameters
        ----------
        name : str
            One of `names`.

        Raises
        ------
        CommissioningError
            There is no such folder.
        """
        place = self._place(name, with_boards=True)
        done = {step: Done(**fields) for step, fields in _read(place / STATE_FILE).items()}
        now = file_sha256(place / CANDIDATE)
        return {step: one for step, one in done.items() if not one.ok or one.sha256 == now}

    def calibrate(self, name: str, who: str, region_y_mm: tuple[float, float] | None = None) -> None:
        """Begin to calibrate from the pictures of a folder; raises `CommissioningError`.

        Parameters
        ----------
        name : str
        who : str
        region_y_mm : tuple of float, optional
            Measuring region along the line, from and to; without: the command's own.
        """
        place = self._place(name, with_boards=True)
        region = [] if region_y_mm is None else ["--region", *(f"{end_mm:g}" for end_mm in region_y_mm)]
        self._begin(name, "calibrated", who, ["calibrate", place, "--output", place / CANDIDATE, *region])

    def verify(self, name: str, who: str, recording: str, diameter_mm: float, expanded_mm: float) -> None:
        """Begin to verify a candidate with a recording of a master bar; raises `CommissioningError`.

        Parameters
        ----------
        name : str
        who : str
        recording : str
            Another folder beside it.
        diameter_mm, expanded_mm : float
            Diameter of the master, and its U (k = 2).
        """
        calibrated = self.steps(name).get("calibrated")
        if calibrated is None or not calibrated.ok:
            raise CommissioningError(f"{name}: not calibrated; calibrate first")
        master = self._place(recording, with_boards=False)
        words: list[str | Path] = ["verify", master, "--rig", self.folder / name / CANDIDATE, "--who", who]
        words += ["--diameter", f"{diameter_mm:g}", "--u", f"{expanded_mm:g}"]
        if self._config is not None:
            words += ["--config", self._config]
        self._begin(name, "verified", who, words)

    def confirm(self, name: str, who: str) -> Path | None:
        """Let the gauge use a candidate that has passed; where the calibration from before is kept, None without one.

        Parameters
        ----------
        name : str
        who : str

        Raises
        ------
        CommissioningError
            It was not verified, a step is being worked on, the settings name no rig file or hold a known error of
            another calibration, a file cannot be written, or the gauge cannot be asked to read it.
        SettingsError
            The settings cannot be read.
        """
        with self._one_at_a_time:
            self._refuse_while_running()
            content = self._verified_content(name)
            rig = self._place_of_rig(sha256(content).hexdigest())
            kept = self._keep_old()
            try:
                with whole_place(rig) as place:
                    place.write_bytes(content)
            except OSError as error:
                raise CommissioningError(f"{rig}: {error.strerror}; let the page's user write it") from error
            refused = ask_for_reload()  # before the log, which may be refused
            self._log(name, who, kept, content)
            if refused:
                raise CommissioningError(
                    f"{rig} is the new calibration, but the gauge could not be asked to read it ({refused}); start it, "
                    "or if it runs: systemctl reload hotgauge"
                )
        return kept

    def log(self) -> list[dict[str, Any]]:
        """Confirmations, newest first: who, when, from which folder, and where the calibration from before is kept.

        A line that a power cut tore is left out.
        """
        try:
            lines = (self.folder / LOG_FILE).read_bytes().splitlines()
        except OSError:
            return []
        return [row for row in map(_row, lines) if row is not None][::-1]

    def _verified_content(self, name: str) -> bytes:
        verified = self.steps(name).get("verified")
        if verified is None or not verified.ok:
            raise CommissioningError(f"{name}: not verified; verify it with a master bar first")
        candidate = self.folder / name / CANDIDATE
        try:
            content = candidate.read_bytes()
        except OSError as error:
            raise CommissioningError(f"{candidate}: {error.strerror}; calibrate again") from error
        if sha256(content).hexdigest() != verified.sha256:
            raise CommissioningError(f"{candidate}: not the one that was verified; verify it with a master bar first")
        return content

    def _place_of_rig(self, digest: str) -> Path:
        if self.rig is None:
            raise CommissioningError("sizing.rig is not set; set it to the file that the gauge shall use")
        if why := self._refusal(digest):
            raise CommissioningError(f"{why}; then confirm again, the gauge reads both at once")
        return self.rig

    def _place(self, name: str, *, with_boards: bool) -> Path:
        if name not in self.names(with_boards=with_boards):  # so a name never is a path
            raise CommissioningError(f"{name!r}: no such folder in {self.folder}; choose one of the list")
        return self.folder / name

    def _keep_old(self) -> Path | None:
        if self.rig is None or not self.rig.is_file():
            return None
        kept = self.rig.with_name(f"{self.rig.stem}-until-{datetime.now(UTC):%Y%m%dT%H%M%SZ}{self.rig.suffix}")
        try:
            shutil.copyfile(self.rig, kept)
        except OSError as error:
            raise CommissioningError(f"{kept}: {error.strerror}; let the page's user write there") from error
        return kept

    def _log(self, name: str, who: str, kept: Path | None, content: bytes) -> None:
        row = {
            "when": _now(),
            "who": who,
            "folder": name,
            "rig": str(self.rig),
            "kept": "" if kept is None else str(kept),
        }
        row["sha256"] = sha256(content).hexdigest()
        log = self.folder / LOG_FILE
        try:
            with log.open("a", encoding="utf-8") as file:
                file.write("\n" * _is_torn(log) + json.dumps(row, ensure_ascii=False) + "\n")
        except OSError as error:
            raise CommissioningError(
                f"{log}: {error.strerror}; {self.rig} is the new calibration, but who confirmed it is not noted"
            ) from error
        logger.info("calibration of %s confirmed by %s; the one from before is %s", name, who, kept)

    def _begin(self, name: str, step: Step, who: str, words: Sequence[str | Path]) -> None:
        with self._one_at_a_time:
            self._refuse_while_running()
            self._running = (name, step)
        threading.Thread(target=self._work, args=(name, step, who, words), daemon=True).start()

    def _refuse_while_running(self) -> None:
        if self._running is not None:
            raise CommissioningError(f"{self._running[0]}: still being worked on; wait until it is done")
        if self.board_pictures.running:
            raise CommissioningError(f"{self.board_pictures.name}: pictures are being taken; stop that first")

    def _work(self, name: str, step: Step, who: str, words: Sequence[str | Path]) -> None:
        try:
            place = self.folder / name
            told = file_sha256(place / CANDIDATE)
            code, report = _run(words)
            found = file_sha256(place / CANDIDATE)
            if step == "verified" and found != told:
                code, report = 1, f"{place / CANDIDATE}: changed while it was verified; verify again\n{report}"
            done = Done(code == 0, who, _now(), report, found)
            earlier = STEPS[: STEPS.index(step)]
            before = {key: fields for key, fields in _read(place / STATE_FILE).items() if key in earlier}
            with whole_file(place / STATE_FILE) as file:
                json.dump(before | {step: done._asdict()}, file, ensure_ascii=False, indent=1)
        except OSError as error:
            logger.warning("commissioning of %s: %s", name, error)
        finally:
            self._running = None


def _run(words: Sequence[str | Path]) -> tuple[int, str]:
    try:
        ended = subprocess.run(
            low_priority_command(words),
            check=False,
            capture_output=True,
            text=True,
            timeout=JOB_MAX_S,
            stdin=subprocess.DEVNULL,
        )
    except subprocess.TimeoutExpired:
        return 1, f"not done within {JOB_MAX_S / 60:.0f} min; take fewer or smaller pictures"
    report = (ended.stdout + ended.stderr).strip()
    if ended.returncode < 0:
        report += f"\nended by signal {-ended.returncode}, as for too little memory; take fewer or smaller pictures"
    return ended.returncode, report.strip()


def _read(file: Path) -> dict[Any, dict[str, Any]]:
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def _row(line: bytes) -> dict[str, Any] | None:
    try:
        row: object = json.loads(line)
    except ValueError:
        return None
    return cast("dict[str, Any]", row) if isinstance(row, dict) else None


def _is_torn(file: Path) -> bool:
    content = file.read_bytes()
    return bool(content) and not content.endswith(b"\n")


def _now() -> str:
    return datetime.now(UTC).astimezone().isoformat(timespec="seconds")
