"""Judges the readings of a recording as the PLC's are judged, for the file that `measure` writes."""

from appliance.conformity.advisor import Advisor
from appliance.conformity.set_points import SetPoints
from appliance.conformity.settings import CorrectionSettings, JudgingSettings
from appliance.files.row_writer import Row
from appliance.sizing.reading_rows import Judge
from plc.codes import Decision
from vision.readings import SizeReading


def row_judge(points: SetPoints, judging: JudgingSettings) -> Judge:
    """Return the function that judges each reading.

    Parameters
    ----------
    points : SetPoints
        What is wanted of a bar.
    judging : JudgingSettings
    """
    advisor = Advisor(judging, CorrectionSettings())

    def judge(reading: SizeReading) -> Row:
        advisor.update(reading, points, 0.0)
        values, decision = advisor.values(), advisor.decision
        deviation_mm, trust = values.get("deviation"), values["trust"]
        return {
            "trust": None if trust is None else float(trust),
            "target_mm": points.target_mm,
            "deviation_mm": None if deviation_mm is None else float(deviation_mm),
            "decision": None if decision is Decision.NONE else decision.name.lower(),
        }

    return judge
