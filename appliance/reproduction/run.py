"""Runs the experiments, keeps each result as soon as it is there, and writes the report."""

import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

from appliance.errors import HotgaugeError
from appliance.files.atomic_file import whole_file
from appliance.reproduction.boards import Boards
from appliance.reproduction.experiment import Case, Experiment, Result
from appliance.reproduction.fusion import FusedViews
from appliance.reproduction.ingots import LINES, IngotEnds
from appliance.reproduction.one_camera import OneCamera
from appliance.reproduction.registration import Registration
from appliance.reproduction.report import write_report
from appliance.reproduction.thermal import Thermal

RESULTS = "results"  # folder of the results within the output's
PLAN = "plan.json"


class ReproductionError(HotgaugeError):
    """The experiments cannot be run or written; the message says what, where and what to do."""


class Plan(NamedTuple):
    """What a folder of results is of; one that was begun with another plan is refused.

    Attributes
    ----------
    quick : bool
        A few cases of each experiment instead of all.
    recordings : str
        Folder of recordings with truth, or nothing.
    """

    quick: bool
    recordings: str


def experiments(recordings: Path | None) -> tuple[Experiment, ...]:
    """All of them, in the dissertation's order."""
    return Thermal(), OneCamera(), Registration(), Boards(), FusedViews(), IngotEnds(recordings)


def reproduce(
    output: Path,
    *,
    quick: bool = False,
    recordings: Path | None = None,
    processes: int = 2,
    on_progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Run what is not there yet, and write the report; run again after an interruption, it goes on.

    Parameters
    ----------
    output : Path
        Folder of results and report.
    quick : bool
        A few cases of each experiment.
    recordings : Path or None
        Folder with `ingot_line` and others, whose truth is known.
    processes : int
        Cases that run at once.
    on_progress : callable
        Called with the number of cases done and their total.

    Returns
    -------
    Path
        The report, HTML; beside it the same as Markdown.

    Raises
    ------
    ReproductionError
        The folder holds results of another plan, or cannot be written; or `recordings` holds none.
    PlotsMissingError
        Matplotlib is not installed.
    """
    if recordings is not None and not any((recordings / line).is_dir() for line in LINES):
        raise ReproductionError(f"{recordings}: holds no recordings of ingots, {' or '.join(LINES)}; give their folder")
    try:
        folder = _prepared(output, Plan(quick, "" if recordings is None else str(recordings.resolve())))
        results = [_Results(folder, experiment, quick) for experiment in experiments(recordings)]
        _run(results, processes, on_progress or _untold)
        sections = [one.experiment.section(one.all()) for one in results]
        return write_report(output, sections, quick=quick)
    except OSError as error:
        place = error.filename or output
        raise ReproductionError(f"{place}: {error.strerror}; give a folder in a place that is writable") from error


def _untold(_done: int, _total: int) -> None:
    """Progress that nobody asked for."""


def _prepared(output: Path, plan: Plan) -> Path:
    folder = output / RESULTS
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / PLAN
    if not file.exists():
        file.write_text(json.dumps(plan._asdict()) + "\n", encoding="utf-8")
    elif json.loads(file.read_text(encoding="utf-8")) != plan._asdict():
        raise ReproductionError(f"{output}: was begun with or without --quick or other recordings; give a new folder")
    return folder


class _Results:
    """Results of one experiment: a line of JSON each, in the order in which they came."""

    def __init__(self, folder: Path, experiment: Experiment, quick: bool) -> None:
        self.experiment = experiment
        self.cases = experiment.cases(quick=quick)
        self._file = folder / f"{experiment.name}.jsonl"
        self._there = dict(self._read())

    def _read(self) -> Iterator[tuple[str, Result]]:
        if not self._file.exists():
            return
        for line in self._file.read_text(encoding="utf-8").splitlines():
            try:
                row: dict[str, Any] = json.loads(line)
            except ValueError:  # the last line, where an interruption cut it
                continue
            yield _key(row["case"]), row["result"]

    @property
    def missing(self) -> list[Case]:
        """Cases without a result."""
        return [case for case in self.cases if _key(case) not in self._there]

    def add(self, case: Case, result: Result) -> None:
        """Keep a result."""
        self._there[_key(case)] = json.loads(json.dumps(result))
        whole = [{"case": one, "result": self._there[_key(one)]} for one in self.cases if _key(one) in self._there]
        with whole_file(self._file) as file:
            file.writelines(json.dumps(row) + "\n" for row in whole)

    def all(self) -> Sequence[tuple[Case, Result]]:
        """Every case with its result."""
        return [(case, self._there[_key(case)]) for case in self.cases]


def _key(case: Case) -> str:
    return json.dumps(case, sort_keys=True)


def _run(results: Sequence[_Results], processes: int, on_progress: Callable[[int, int], None]) -> None:
    total = sum(len(one.cases) for one in results)
    todo = [(one, case) for one in results for case in one.missing]
    done = total - len(todo)
    on_progress(done, total)
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        waiting: dict[Future[Result], tuple[_Results, Case]] = {
            pool.submit(one.experiment.run, case): (one, case) for one, case in todo
        }
        for finished in as_completed(waiting):
            one, case = waiting.pop(finished)
            one.add(case, finished.result())
            done += 1
            on_progress(done, total)
