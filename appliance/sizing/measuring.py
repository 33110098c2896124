"""Interface of a sizing method to the command `measure`: its names, its options, and the function that measures.

The table of them is in `appliance.cli.pictures.measure`. Nothing here loads an image library before a method runs.
"""

import argparse
from abc import ABC, abstractmethod
from typing import ClassVar

from appliance.sizing.reading_rows import Judge


class Measuring(ABC):
    """Runs the command `measure` with the methods of one folder.

    Attributes
    ----------
    names : tuple of str
        Choices of `--method` that this class runs.
    text : str
        Explanation of these choices in the help of `--method`.
    options : tuple of str
        Options that apply to these methods, as attributes of the parsed command line; others are refused. `rig` and
        `plot` are declared by the command itself.
    """

    names: ClassVar[tuple[str, ...]]
    text: ClassVar[str]
    options: ClassVar[tuple[str, ...]]

    @abstractmethod
    def add_options(self, command: argparse.ArgumentParser) -> None:
        """Declare the options that only these methods have."""

    @abstractmethod
    def run(self, given: argparse.Namespace, judge: Judge) -> list[str]:
        """Measure the recording; lines of a summary for the terminal.

        Parameters
        ----------
        given : Namespace
            Parsed command line without options of other methods.
        judge : callable
            Compares each reading with what is wanted.

        Raises
        ------
        CommandError
            The command line, the recording, the rig or the empty line cannot be used.
        OSError
            A file cannot be written.
        """
