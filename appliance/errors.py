"""The tree of errors that a person reads: each message says in one sentence what, where and what to do.

::

    HotgaugeError
    +-- CommandError              command_options            the command line cannot be used
    +-- SettingsError             settings.file              the settings file cannot be used
    +-- StartRefusedError         supervisor.start_gate      the appliance cannot start with these settings
    +-- CameraError               cameras.source             a source gives no pictures; names its fault
    |   +-- EndOfRecording        cameras.source             a recording was played once and is over
    +-- ScaleError                sizing.method              nothing makes millimetres of pixels; names its fault
    |   +-- RigError              sizing.stereo.rig_file     no usable rig file
    |   +-- EdgeModelError        sizing.stereo.edge_model no usable edge forest
    |   +-- EmptyLineError        sizing.conveyor.empty_line no usable picture of the empty line
    |   +-- AdjustmentError       sizing.method              a known error that was found with another calibration
    +-- CaptureError              capture.error              pictures cannot be taken or kept
    +-- ReferencesError           ingot.reader_setup         no usable references of the ingots' ends
    +-- ArchiveError              archives.recordings        a folder of recordings cannot be measured
    +-- LearnedReferencesError ingot.learned_references    no usable history of references
    +-- HistoryError              history.schema             the history cannot be read
    +-- ParquetMissingError       files.parquet              the library of Parquet files is not installed
    +-- ReportMissingError        reports.pages              a library that makes pages is not installed
    +-- StudyError                verification.gauge_study   measurements are no gauge study
    +-- PlcInputsError            conformity.plc_inputs      what the PLC had written cannot be read again
    +-- ComparisonError           comparison.files           readings and truth cannot be compared
    +-- FusionError               sizing.stereo.fuse_files   two pictures cannot be fused
    +-- PlotsMissingError         sizing.figures             the plotting library is not installed
    +-- OutputError               simulation.write_recording a recording cannot be written
    +-- TrainingError             training.edge_forest       a model cannot be trained or written
    +-- ReproductionError         reproduction.run           the experiments cannot be run or written
    +-- PlanError                 planning.expected          a planned mounting cannot work
    +-- PageError                 page.serve                 the page cannot be served
    +-- CommissioningError        page.commissioning         a step of commissioning cannot be done
    +-- UsersError                page.access.users          the page's file of users cannot be used
    +-- InstallError              service.install            the service cannot be installed

Two rooms that know nothing of the appliance have errors of their own: `plc.poll.PollError` (a gauge does not answer as
one should), `plc.listener.BindError` (a port cannot be had), `plc.security.identity.CertificateError` (a certificate
cannot be used) and `vision.calibration.acceptance.CalibrationError` (board pictures give no calibration). A wrong
call raises `ValueError` or `TypeError`, and data that show no bar raise nothing.
"""


class HotgaugeError(Exception):
    """Trouble that a person can mend; its message is the sentence that the person reads."""


def reading_advice(error: OSError, otherwise: str) -> str:
    """What to do about a file that cannot be read, as the end of a sentence that says which and why.

    Parameters
    ----------
    error : OSError
    otherwise : str
        Advice where the file is neither kept from this user nor a folder.
    """
    if isinstance(error, PermissionError):
        return "let this user read it"
    return "give a file, not a folder" if isinstance(error, IsADirectoryError) else otherwise
