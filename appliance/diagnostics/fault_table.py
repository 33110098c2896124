"""The fault table: trouble with the equipment, its NE 107 class, its text and its remedy."""

import logging
from typing import NamedTuple

from plc.codes import DeviceState

CALM_S = 60.0  # twelve of the windows in which rates and losses are judged


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
    bit : int
        Bit of `fault_word`; never changes its meaning.
    alarm : str
        Alarm of the alarm table that it causes; empty for none.
    latching : bool
        Whether the bit stays after the fault is over, with "maintenance required", until it is acknowledged.
    off_after_s : float
        Time without the fault before it is over, so that one at its limit does not come and go.
    """

    code: int
    name: str
    state: DeviceState
    severity: int
    text: str
    remedy: str
    bit: int
    alarm: str = ""
    latching: bool = False
    off_after_s: float = 0.0

    @property
    def reported_by_station(self) -> bool:
        """Whether it is a measuring process that knows of it."""
        return self.code < 300


FAULTS: tuple[FaultRow, ...] = (
    FaultRow(
        101,
        "camera_lost",
        DeviceState.FAILURE,
        logging.ERROR,
        "the cameras give no pictures",
        "check power and cables of both cameras, or the path of the recording",
        bit=0,
        alarm="alarm_camera",
    ),
    FaultRow(
        102,
        "recording_over",
        DeviceState.FUNCTION_CHECK,
        logging.WARNING,
        "the recording was played once and is over",
        "start again, or set sizing.camera.loop = true",
        bit=1,
    ),
    FaultRow(
        103,
        "camera_frozen",
        DeviceState.FAILURE,
        logging.ERROR,
        "a camera delivers the same picture again and again",
        "restart the camera by its power; if it comes back, replace it",
        bit=2,
        alarm="alarm_camera",
    ),
    FaultRow(
        104,
        "pair_out_of_step",
        DeviceState.FAILURE,
        logging.ERROR,
        "the two cameras do not expose at the same moment",
        "check the synchronisation cable or the network's clock",
        bit=3,
        alarm="alarm_camera",
    ),
    FaultRow(
        105,
        "picture_blank",
        DeviceState.FAILURE,
        logging.ERROR,
        "a camera's picture is black, or even all over",
        "take off the lens cap, clean the window, check the exposure",
        bit=4,
        alarm="alarm_camera",
    ),
    FaultRow(
        106,
        "picture_size_changed",
        DeviceState.FAILURE,
        logging.ERROR,
        "a camera's pictures have changed their size",
        "restart the camera with the size that it was calibrated with",
        bit=5,
        alarm="alarm_camera",
    ),
    FaultRow(
        107,
        "camera_clock_wrong",
        DeviceState.FAILURE,
        logging.ERROR,
        "a camera's clock jumps, so the age of its pictures is unknown",
        "restart the camera; if it comes back, replace it",
        bit=6,
        alarm="alarm_camera",
    ),
    FaultRow(
        108,
        "pairs_dropped",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "more image pairs are lost than may be",
        "set a lower camera rate or take a faster computer; check the cameras' network",
        bit=7,
        off_after_s=CALM_S,
    ),
    FaultRow(
        109,
        "pairs_slow",
        DeviceState.OUT_OF_SPECIFICATION,
        logging.WARNING,
        "image pairs come too slowly for a moving line",
        "check the cameras' rate and network; a slow computer lowers it too",
        bit=8,
        off_after_s=CALM_S,
    ),
    FaultRow(
        110,
        "camera_hot",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "a camera is too hot",
        "check its cooling and its heat shield",
        bit=24,
        off_after_s=CALM_S,
    ),
    FaultRow(
        111,
        "exposure_high",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "the edges of the bars are overexposed",
        "shorten the cameras' exposure, or close the lenses' apertures a little",
        bit=25,
        off_after_s=CALM_S,
    ),
    FaultRow(
        112,
        "exposure_low",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "the bars are too dark in the pictures",
        "clean the windows; then lengthen the cameras' exposure",
        bit=26,
        off_after_s=CALM_S,
    ),
    FaultRow(
        113,
        "range_lost",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "the laser beside the cameras does not answer; the cameras measure without it",
        "check its power and network, and host, port, unit_id and address of sizing.range",
        bit=23,
    ),
    FaultRow(
        201,
        "rig_unusable",
        DeviceState.FAILURE,
        logging.ERROR,
        "the calibration of the two cameras cannot be used",
        "run hotgauge calibrate and set sizing.rig to the file that it writes",
        bit=9,
        alarm="alarm_calibration",
    ),
    FaultRow(
        202,
        "references_unusable",
        DeviceState.FAILURE,
        logging.ERROR,
        "the references or regions of the ingot camera cannot be used",
        "mend the folder that ingot.references names, or the settings under ingot",
        bit=19,
        alarm="alarm_calibration",
    ),
    FaultRow(
        203,
        "empty_line_unusable",
        DeviceState.FAILURE,
        logging.ERROR,
        "the picture of the empty line cannot be used, or shows no pair of barriers",
        "set sizing.conveyor.background to a picture of the line without a bar, by this camera",
        bit=20,
        alarm="alarm_calibration",
    ),
    FaultRow(
        301,
        "reading_stale",
        DeviceState.FAILURE,
        logging.ERROR,
        "the newest reading is too old",
        "wait for the measuring process to be started again; if it comes back, the computer is overloaded",
        bit=10,
        alarm="alarm_stale",
    ),
    FaultRow(
        302,
        "not_measuring",
        DeviceState.FAILURE,
        logging.ERROR,
        "the measuring process runs but measures nothing",
        "wait a minute for it to be started again; if it comes back, send the log to the maker",
        bit=11,
        alarm="alarm_internal",
    ),
    FaultRow(
        303,
        "contrast_low",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "bars have stood out weakly from their background for a while",
        "clean the windows of both cameras and look for steam and light in front of them",
        bit=28,
    ),
    FaultRow(
        305,
        "calibration_due",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "the calibration is due: a camera has moved, or a verification failed or is too old",
        "if a camera has moved, fix it and run hotgauge calibrate; then run hotgauge verify",
        bit=30,
        alarm="alarm_calibration",
    ),
    FaultRow(
        401,
        "station_restarting",
        DeviceState.FAILURE,
        logging.ERROR,
        "the measuring process ended and is started again",
        "if it comes back, send the log to the maker",
        bit=12,
        alarm="alarm_internal",
    ),
    FaultRow(
        402,
        "station_failing",
        DeviceState.FAILURE,
        logging.ERROR,
        "the measuring process keeps ending; it is tried again at longer intervals",
        "read in the log why it ends; run hotgauge doctor; send the log to the maker",
        bit=13,
        latching=True,
        alarm="alarm_internal",
    ),
    FaultRow(
        501,
        "set_points_not_saved",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "what the PLC has written cannot be kept over a restart",
        "make room on the disk and the folder plc.state_directory writable",
        bit=14,
    ),
    FaultRow(
        502,
        "set_points_unreadable",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "what the PLC had written before the restart is lost",
        "let the PLC write its set points again",
        bit=15,
        latching=True,
    ),
    FaultRow(
        503,
        "settings_unusable",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "the settings file is wrong; the settings from before stay in force",
        "run hotgauge check-config on the file, correct it and reload",
        bit=16,
    ),
    FaultRow(
        504,
        "restart_needed",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "settings have changed that count only after a restart",
        "restart the gauge when the line stands",
        bit=17,
    ),
    FaultRow(
        505,
        "clock_stepped",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "the computer's clock was set; time stamps before and after do not fit together",
        "check the time server; measuring is not affected",
        bit=18,
    ),
    FaultRow(
        506,
        "certificate_due",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "a certificate of the secure port ends within 30 days, or has ended",
        "make a new one with hotgauge certificates; it counts within seconds, without a restart",
        bit=21,
    ),
    FaultRow(
        507,
        "certificate_unusable",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.ERROR,
        "the files of the secure port cannot be used",
        "see the log for which; make them with hotgauge certificates and let the gauge's user read them",
        bit=22,
    ),
    FaultRow(
        521,
        "history_not_written",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "what is measured, or the pictures of an alarm, cannot be kept",
        "make room on the disk and the folders of history and black box writable; measuring is not affected",
        bit=29,
    ),
    FaultRow(
        522,
        "history_damaged",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "the history was damaged; it was set aside and a new one begun",
        "check the disk; sqlite3's .recover may read what was set aside",
        bit=31,
        latching=True,
    ),
    FaultRow(
        523,
        "delivery_failed",
        DeviceState.MAINTENANCE_REQUIRED,
        logging.WARNING,
        "readings cannot be sent by MQTT, or figures not be served to Prometheus",
        "see the log for why; check the broker, the network and the settings under mqtt and metrics",
        bit=27,
    ),
)
