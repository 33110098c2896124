"""One decision per ingot: the evidence of its pictures, added up from the first one on the line.

A sequential test after Wald (doi:10.1214/aoms/1177731118): evidence is added until one of two bounds is passed.
Pictures of one ingot show the same face and err together, so n of them count as n / (1 + (n - 1) rho) independent ones.
"""

import math
from dataclasses import dataclass, field

from vision.ingot.classifiers.ssim import Orientation
from vision.readings import OrientationReading
from vision.reasons import IngotReason

LIFT_SHARE = 0.1  # chosen, of the radius: an end that has moved further up in the picture was lifted


@dataclass(frozen=True, slots=True, kw_only=True)
class DecisionRule:
    """Bounds of the evidence for a decision, and the pictures that belong to one ingot.

    Attributes
    ----------
    false_alarm : float
        Accepted probability that a bottom is called a top.
    missed : float
        Accepted probability that a top is called a bottom.
    late_false_alarm, late_missed : float
        The same for an ingot that is still undecided after `late_frames` pictures; to call it a bottom then costs no
        more than to leave it undecided.
    late_frames : int
    correlation : float
        rho, between the evidence of two pictures of one ingot. 0.8: on 300 simulated tops and 300 bottoms that the
        evidence was not fitted to, the mean evidence of an ingot was worth 1.2 times that of a picture.
    evidence_limit : float
        Most that one picture may say, in natural logarithms of odds.
    least_frames : int
        Pictures before which nothing is decided.
    still : float
        Longest way from one picture to the next, in radii of the end, of an ingot that lies on the line.
    gone_frames : int
        Pictures without an end after which the ingot is gone.
    """

    false_alarm: float = 1e-4
    missed: float = 1e-3
    late_false_alarm: float = 0.02
    late_missed: float = 0.2
    late_frames: int = 15
    correlation: float = 0.8
    evidence_limit: float = 10.0
    least_frames: int = 3
    still: float = 0.2
    gone_frames: int = 5

    def __post_init__(self) -> None:
        for name in ("false_alarm", "missed", "late_false_alarm", "late_missed"):
            if not 0 < getattr(self, name) < 0.5:
                raise ValueError(f"{name} must be above 0 and below 0.5, got {getattr(self, name)}")
        if not 0 <= self.correlation < 1:
            raise ValueError(f"correlation must be from 0 to below 1, got {self.correlation}")

    def decide(self, evidence: float, frames: int) -> Orientation:
        """Orientation that the evidence allows.

        Parameters
        ----------
        evidence : float
            Natural logarithm of the odds of a top against a bottom.
        frames : int
            Pictures that it comes from.

        Returns
        -------
        {"top", "bottom", "undecided"}
        """
        if frames < self.least_frames:
            return "undecided"
        late = frames >= self.late_frames
        false_alarm = self.late_false_alarm if late else self.false_alarm
        missed = self.late_missed if late else self.missed
        if evidence >= math.log((1 - missed) / false_alarm):
            return "top"
        return "bottom" if evidence <= math.log(missed / (1 - false_alarm)) else "undecided"


@dataclass(frozen=True, slots=True, kw_only=True)
class IngotDecision:
    """Orientation of one ingot, and the evidence for it.

    Attributes
    ----------
    ingot : int
        Number of the ingot, from 1.
    orientation : {"top", "bottom", "undecided"}
    first_frame : int
        First picture with its end on the line.
    decided_frame : int or None
        Picture that decided; None while undecided.
    confidence : float
        Probability of the orientation, or of the likelier one while undecided, in percent.
    ssim_top, ssim_bottom : float
        Means over the pictures that counted; NaN before the first.
    """

    ingot: int
    orientation: Orientation
    first_frame: int
    decided_frame: int | None
    confidence: float
    ssim_top: float
    ssim_bottom: float


@dataclass(slots=True)
class _Followed:
    first_frame: int
    last: OrientationReading
    number: int = 0
    missing: int = 0
    frames: int = 0
    log_odds: float = 0.0
    ssim_top: float = 0.0
    ssim_bottom: float = 0.0
    decided: IngotDecision | None = field(default=None)


class IngotFollower:
    """Turns readings of successive pictures into one decision per ingot.

    A picture counts when the end has lain still since the one before, or moved no faster than the line: not while an
    ingot is set down, lifted, or leaves. It is an ingot as soon as `least_frames` pictures count.

    Parameters
    ----------
    rule : DecisionRule
    """

    def __init__(self, rule: DecisionRule | None = None) -> None:
        self._rule = rule or DecisionRule()
        self._ingots = 0
        self._now: _Followed | None = None

    @property
    def current(self) -> IngotDecision | None:
        """Decision on the ingot on the line, or its evidence so far; None without an ingot."""
        now = self._now
        if now is None or not now.number:
            return None
        return now.decided or self._known(now, None)

    def add(self, frame: int, reading: OrientationReading) -> list[IngotDecision]:
        """Take the next picture into account.

        Parameters
        ----------
        frame : int
            Number of the picture.
        reading : OrientationReading

        Returns
        -------
        list of IngotDecision
            Of the ingot that has left undecided, and of the one that is decided by this picture; mostly empty.
        """
        if not reading.present:
            return self._miss(reading)
        ended: list[IngotDecision] = []
        if self._now is not None and not _goes_on(self._now.last, reading):
            ended = self.end()
        if self._now is None:
            self._now = _Followed(frame, reading)
            return ended
        return ended + self._add(self._now, frame, reading)

    def end(self) -> list[IngotDecision]:
        """End the ingot on the line: it is gone, or no more pictures come.

        Returns
        -------
        list of IngotDecision
            Its decision, unless `take` returned it before.
        """
        now, self._now = self._now, None
        if now is None or not now.number or now.decided is not None:
            return []
        return [self._known(now, None)]

    def _miss(self, reading: OrientationReading) -> list[IngotDecision]:
        now = self._now
        if now is None:
            return []
        now.missing += 1
        hung = now.decided is None and bool(reading.reasons & IngotReason.HANGING)  # then what was read is void
        return self.end() if hung or now.missing >= self._rule.gone_frames else []

    def _add(self, now: _Followed, frame: int, reading: OrientationReading) -> list[IngotDecision]:
        still = self._lies(now, reading)
        now.last, now.missing = reading, 0
        if not still:
            return []
        limit = self._rule.evidence_limit
        now.frames += 1
        now.log_odds += min(max(reading.log_odds, -limit), limit)
        now.ssim_top += reading.ssim_top
        now.ssim_bottom += reading.ssim_bottom
        if not now.number and now.frames >= self._rule.least_frames:
            self._ingots += 1
            now.number = self._ingots
        return self._decide(now, frame)

    def _lies(self, now: _Followed, reading: OrientationReading) -> bool:
        """Whether it moved no faster than the line since it was last seen, and not up, as only the crane moves it."""
        longest = self._rule.still * reading.radius * (1 + now.missing)
        return _way(now.last, reading) <= longest and reading.center_y > now.last.center_y - LIFT_SHARE * reading.radius

    def _decide(self, now: _Followed, frame: int) -> list[IngotDecision]:
        if now.decided is not None or self._rule.decide(self._evidence(now), now.frames) == "undecided":
            return []
        now.decided = self._known(now, frame)
        return [now.decided]

    def _evidence(self, now: _Followed) -> float:
        return now.log_odds / (1 + max(0, now.frames - 1) * self._rule.correlation)

    def _known(self, now: _Followed, decided_frame: int | None) -> IngotDecision:
        evidence, frames = self._evidence(now), now.frames
        return IngotDecision(
            ingot=now.number,
            orientation="undecided" if decided_frame is None else self._rule.decide(evidence, frames),
            first_frame=now.first_frame,
            decided_frame=decided_frame,
            confidence=100 / (1 + math.exp(-abs(evidence))),
            ssim_top=now.ssim_top / frames if frames else math.nan,
            ssim_bottom=now.ssim_bottom / frames if frames else math.nan,
        )


def _way(before: OrientationReading, after: OrientationReading) -> float:
    return math.hypot(after.center_x - before.center_x, after.center_y - before.center_y)


def _goes_on(before: OrientationReading, after: OrientationReading) -> bool:
    """Whether two ends can be of one ingot: the line carries it towards the camera, never back or aside."""
    reach = max(before.radius, after.radius)
    return after.center_y > before.center_y - reach / 2 and abs(after.center_x - before.center_x) < reach
