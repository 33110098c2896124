"""Refuses output files that would destroy what a command reads."""

import os
from collections.abc import Iterable
from pathlib import Path

from appliance.command_options import CommandError

INPUT_NAMES = frozenset(
    {"board.json", "roi.json", "timestamps.csv", "truth.csv", "truth.json", "truth_rig.json", "top.png", "bottom.png"}
)
INPUT_SUFFIXES = frozenset({".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".mp4", ".mkv", ".avi", ".mov"})
PICTURE_FOLDERS = frozenset({"left", "right", "calibration", "registration"})
ROW_SUFFIXES = frozenset({"", ".csv", ".jsonl", ".json", ".ndjson", ".txt"})


def refuse_lost_input(output: Path, inputs: Iterable[Path | None], option: str = "--output") -> None:
    """Raise `CommandError` if writing an output would replace an input.

    Parameters
    ----------
    output : Path
        File to write.
    inputs : iterable of Path or None
        Files and folders that the command reads; None for one that was not given. In a folder, pictures, videos and the
        files of a recording or a rig folder are inputs, and other files are not.
    option : str
        Which names the output, for the sentence.

    Raises
    ------
    CommandError
        Output and input are the same file, or the output is an input inside one of the folders.
    """
    place = output.resolve()
    for given in inputs:
        if given is None or not place.exists():
            continue
        read = given.resolve()
        is_inside = read.is_dir() and place.is_relative_to(read) and _is_input(place)
        if place == read or is_inside or (read.is_file() and place.samefile(read)):
            raise CommandError(f"{option}: {output} is read by this command and would be lost; give another file")


def refuse_unwritable(output: Path, option: str = "--output") -> None:
    """Raise `CommandError`, before any work is done, for an output that cannot be written when it is done.

    Parameters
    ----------
    output : Path
    option : str
        Which names it, for the sentence.
    """
    folder = output.parent
    if not folder.is_dir():
        raise CommandError(f"{option}: {output}: there is no folder {folder}; make it, or give another file")
    if output.is_dir():
        raise CommandError(f"{option}: {output} is a folder; give the name of a file in it")
    if output.exists() and not output.is_file():
        raise CommandError(f"{option}: {output} is a device or a pipe; give the name of a file")
    if not os.access(folder, os.W_OK):
        raise CommandError(f"{option}: {folder} is not writable; give a file in a writable folder")


def refuse_plots_among_inputs(plots: Path | None, inputs: Iterable[Path | None]) -> None:
    """Raise `CommandError` for a folder of plots that holds pictures which the command reads.

    Plots would replace pictures of the same names, and count as pictures of the recording the next time.

    Parameters
    ----------
    plots : Path or None
        Folder that `--plot` names; None without plots.
    inputs : iterable of Path or None
        Recordings, folders of pictures and pictures; None for one that was not given.

    Raises
    ------
    CommandError
        The folder is a recording, one of its folders of pictures, or the folder of a picture; or it is a file.
    """
    if plots is None:
        return
    if plots.exists() and not plots.is_dir():
        raise CommandError(f"--plot: {plots} is a file; give a folder, which is made if it is missing")
    place = plots.resolve()
    for given in inputs:
        if given is None or not given.exists():
            continue
        folder = given.resolve() if given.is_dir() else given.resolve().parent
        if place == folder or (place.parent == folder and place.name.lower() in PICTURE_FOLDERS):
            raise CommandError(f"--plot: {plots} holds pictures that this command reads; give another folder")


def refuse_other_formats(output: Path) -> None:
    """Raise `CommandError` for a name that promises neither CSV nor JSON lines, or is nothing but a suffix."""
    if output.name in ROW_SUFFIXES:
        raise CommandError(f"--output: {output} is a suffix without a name; give a name before it")
    if output.suffix.lower() not in ROW_SUFFIXES or output.name == "-":
        raise CommandError(f"--output: {output} is neither CSV nor JSON lines; let its name end in .csv or .jsonl")


def _is_input(place: Path) -> bool:
    return place.name in INPUT_NAMES or place.suffix.lower() in INPUT_SUFFIXES
