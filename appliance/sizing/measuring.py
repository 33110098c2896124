"""What a sizing method must give to the command `measure`: its names, its options, and what runs it.

The table of them is in `appliance.cli.measure`. Nothing here loads an image library before a method runs.
"""

import argparse
from abc import ABC, abstractmethod
from typing import ClassVar


class Measuring(ABC):
    """How recordings are measured with the methods of one room.

    Attributes
    ----------
    names : tuple of str
        Choices of `--method` that this room runs.
    text : str
        The choices in the help of `--method`.
    options : tuple of str
        Options that have a meaning here, as attributes of the parsed command line. `rig` and `plot` belong to the
        command; every room may name them.
    """

    names: ClassVar[tuple[str, ...]]
    text: ClassVar[str]
    options: ClassVar[tuple[str, ...]]

    @abstractmethod
    def add_options(self, command: argparse.ArgumentParser) -> None:
        """Declare the options that no other room has."""

    @abstractmethod
    def run(self, given: argparse.Namespace) -> None:
        """Measure the recording.

        Parameters
        ----------
        given : Namespace
            Parsed command line without options of other rooms.

        Raises
        ------
        CommandError
            The command line, the recording or what makes millimetres of pixels cannot be used.
        OSError
            A file cannot be written.
        """
