"""The fault table and the one door through which faults come and go.

A fault is trouble with the equipment, not with the bar. It owns the NE 107 class that the PLC reads as
`device_state`; it is logged once when it comes and once when it goes.
"""

import enum
import logging
from typing import NamedTuple

logger = logging.getLogger("hotgauge.faults")


class DeviceState(enum.IntEnum):
    """NAMUR NE 107 classes; the larger number is the worse state."""

    GOOD = 0
    MAINTENANCE_REQUIRED = 1
    OUT_OF_SPECIFICATION = 2
    FUNCTION_CHECK = 3
    FAILURE = 4


class FaultRow(NamedTuple):
    """One row of the fault table.

    Attributes
    ----------
    code : int
        Number for people and logs; never changes its meaning.
    name : str
    state : DeviceState
        NE 107 class while the fault is active.
    severity : int
        Log level (`logging.WARNING`, `logging.ERROR`) when it comes.
    text : str
        What the operator reads.
    remedy : str
        What to do about it.
    """

    code: int
    name: str
    state: DeviceState
    severity: int
    text: str
    remedy: str


FAULTS: tuple[FaultRow, ...] = (
    FaultRow(
        101,
        "camera_lost",
        DeviceState.FAILURE,
        logging.ERROR,
        "the cameras give no pictures",
        "check power and cables of both cameras, or the path of the recording",
    ),
    FaultRow(
        102,
        "recording_over",
        DeviceState.FUNCTION_CHECK,
        logging.WARNING,
        "the recording was played once and is over",
        "start again, or set sizing.camera.loop = true",
    ),
    FaultRow(
        103,
        "contrast_low",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "bars have stood out weakly from their background for a while",
        "clean the windows of both cameras and look for steam and light in front of them",
    ),
    FaultRow(
        104,
        "edges_overexposed",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "edges of the bars have been overexposed for a while",
        "shorten the exposure of both cameras",
    ),
    FaultRow(
        201,
        "rig_unusable",
        DeviceState.FAILURE,
        logging.ERROR,
        "the calibration of the two cameras cannot be used",
        "run hotgauge calibrate and set sizing.rig to the file that it writes",
    ),
    FaultRow(
        202,
        "calibration_due",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "a camera has moved since its calibration",
        "fix the cameras and run hotgauge calibrate",
    ),
    FaultRow(
        301,
        "reading_stale",
        DeviceState.FAILURE,
        logging.ERROR,
        "the newest reading is too old",
        "wait for the measuring process to be started again; if it comes back, the computer is overloaded",
    ),
    FaultRow(
        401,
        "station_down",
        DeviceState.FAILURE,
        logging.ERROR,
        "the measuring process ended and is started again",
        "if it comes back, send the log to the maker",
    ),
    FaultRow(
        501,
        "set_points_not_saved",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "what the PLC has written cannot be kept over a restart",
        "make room on the disk and the folder plc.state_directory writable",
    ),
    FaultRow(
        502,
        "set_points_unreadable",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "what the PLC had written before the restart is lost",
        "let the PLC write its set points again",
    ),
)

_ROWS = {row.name: row for row in FAULTS}


class Faults:
    """The faults that are active now."""

    def __init__(self) -> None:
        self._active: set[str] = set()

    def report(self, name: str, *, active: bool, detail: str = "") -> None:
        """Say whether a fault is there; only a change is logged.

        Parameters
        ----------
        name : str
            Name in `FAULTS`.
        active : bool
        detail : str
            What exactly is wrong, for the log.

        Raises
        ------
        ValueError
            `name` is not in the table.
        """
        if name not in _ROWS:
            raise ValueError(f"name: no fault is called {name!r}")
        if active == (name in self._active):
            return
        row = _ROWS[name]
        if active:
            self._active.add(name)
            logger.log(row.severity, "fault %d %s: %s; %s", row.code, name, detail or row.text, row.remedy)
        else:
            self._active.remove(name)
            logger.info("fault %d %s is over", row.code, name)

    @property
    def active(self) -> frozenset[str]:
        """Names of the faults that are there now."""
        return frozenset(self._active)

    @property
    def state(self) -> DeviceState:
        """NE 107 class of the worst active fault."""
        return max((_ROWS[name].state for name in self._active), default=DeviceState.GOOD)
