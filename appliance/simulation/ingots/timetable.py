"""Who is where and when: the crane brings ingots, sets them down, the rollers take them to the rolls."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from appliance.simulation.ingots.faces import LABELS, Label, Rng
from appliance.simulation.ingots.line import IngotLine
from appliance.simulation.ingots.solid import Ingot, Pose

State = Literal["empty", "hanging", "lowering", "placed", "leaving"]

LEAVING_STEPS = (0.08, 0.14, 0.22, 0.32, 0.45, 0.6, 0.8, 1.0)  # of the way's length, frame by frame
OVEREXPOSURE = (1.5, 2.3)
FRAMES_TOGETHER = 40
LOW, LOWEST = (2.2, 4.5), (1.3, 3.0)  # heights over the radius down to which ingots hang


@dataclass(frozen=True, slots=True)
class Sight:
    """One ingot in one frame.

    Attributes
    ----------
    ingot : Ingot
    pose : Pose
    state : str
    heating : float
        How many times brighter it is than when it was set down.
    tongs_mm : float
        How high the crane's tongs are above their grip; infinite when they are gone.
    """

    ingot: Ingot
    pose: Pose
    state: State
    heating: float = 1.0
    tongs_mm: float = float("inf")


@dataclass(frozen=True, slots=True)
class Glare:
    """A bright reflection of a lamp on the line.

    Attributes
    ----------
    place_mm : tuple of float
        x, y of its middle.
    size_mm : tuple of float
        Half widths in x and y.
    level : float
        Light over full scale.
    warmth : float
        0 white, 1 orange.
    seed : int
        Of its ragged outline.
    """

    place_mm: tuple[float, float]
    size_mm: tuple[float, float]
    level: float
    warmth: float
    seed: int


@dataclass(frozen=True, slots=True)
class Moment:
    """What a frame shows.

    Attributes
    ----------
    sights : tuple of Sight
        Those furthest from the camera first; the truth is about the last one on the line, or else the last.
    exposure : float
        Over the line's own.
    glare : Glare or None
    """

    sights: tuple[Sight, ...] = ()
    exposure: float = 1.0
    glare: Glare | None = None


def timetable(line: IngotLine, ingots: int | None = None) -> Iterator[Moment]:
    """Moments of a line, frame after frame: some ingots, or without end."""
    rng = np.random.default_rng([line.seed, 0x7474])
    if not line.habits.ingots:
        yield from _without_ingots(line, rng, ingots)
        return
    number = 0
    labels = _labels(rng)
    while ingots is None or number < ingots:
        yield from (Moment() for _ in range(int(rng.integers(3, 7))))
        together = min(line.habits.in_view, line.habits.in_view if ingots is None else ingots - number)
        yield from _group(line, rng, [next(labels) for _ in range(together)])
        number += together
    yield from (Moment() for _ in range(int(rng.integers(2, 5))))


def _labels(rng: Rng) -> Iterator[Label]:
    """As many tops as bottoms, in pairs of random order."""
    while True:
        first = int(rng.integers(2))
        yield LABELS[first]
        yield LABELS[1 - first]


def _group(line: IngotLine, rng: Rng, labels: list[Label]) -> Iterator[Moment]:
    """The ingots that are on the line together, each set down behind the one before."""
    tracks: list[list[Sight]] = []
    starts: list[int] = []
    start, behind_mm = 0, 0.0
    for label in labels:
        ingot = line.ingot(label, rng)
        brought = _brought(line, ingot, rng, behind_mm)
        if line.habits.set_down:
            way = _placed(line, ingot, rng, behind_mm)
        else:
            brought = [replace(sight, state="hanging") for sight in brought]
            way = brought[::-1]
        tracks.append(brought + way)
        starts.append(start)
        start += len(brought) + len(way) // 4
        behind_mm += ingot.length_mm + rng.uniform(0.5, 1.5) * line.radius_mm
    count = max(start + len(track) for start, track in zip(starts, tracks, strict=True))
    glare, glaring = _glare(line, rng, tracks[0], starts[0])
    exposure, exposed = _overexposure(line, rng, tracks[0], starts[0])
    for frame in range(count):
        sights = [
            track[frame - start] for start, track in zip(starts, tracks, strict=True) if 0 <= frame - start < len(track)
        ]
        yield Moment(
            tuple(reversed(sights)),
            exposure if frame in exposed else 1.0,
            glare if frame in glaring else None,
        )


def _brought(line: IngotLine, ingot: Ingot, rng: Rng, behind_mm: float) -> list[Sight]:
    """The crane brings an ingot, level between its tongs or upright, and lowers it."""
    hanging, lowering = int(rng.integers(5, 10)), int(rng.integers(0, 4))
    radius = line.radius_mm
    upright = rng.random() < 0.5
    side_mm = rng.choice([0.0, rng.uniform(-6, 6)]) * radius
    high_mm = rng.uniform(8, 14) * radius
    low_mm = rng.uniform(*(LOW if line.habits.set_down else LOWEST)) * radius
    pitch_deg = rng.uniform(80, 92) if upright else rng.uniform(-4, 6)
    y_mm = rng.uniform(-0.15, 0.05) * line.travel_mm - behind_mm
    sights: list[Sight] = []
    for number in range(hanging):
        done = ((number + 1) / hanging) ** 0.8
        swing = rng.normal(0, 0.05) * radius
        end = (side_mm * (1 - done) + swing, y_mm, high_mm + (low_mm - high_mm) * done)
        pose = Pose(end, rng.normal(0, 2.5), pitch_deg + rng.normal(0, 1))
        sights.append(Sight(ingot, pose, "hanging", tongs_mm=0.0))
    for number in range(lowering):
        left = 1 - (number + 1) / (lowering + 1)
        end = (rng.normal(0, 0.03) * radius, y_mm, radius + (low_mm - radius) * left)
        sights.append(Sight(ingot, Pose(end, rng.normal(0, 1.5), pitch_deg * left), "lowering", tongs_mm=0.0))
    return sights


def _placed(line: IngotLine, ingot: Ingot, rng: Rng, behind_mm: float) -> list[Sight]:
    """An ingot stands or moves on the line, then leaves for the rolls."""
    frames = int(rng.integers(22, 56))
    standing = int(rng.integers(0, frames // 2) * rng.integers(2))
    if line.habits.in_view > 1:  # ingots that move with the same rollers keep their distance
        frames, standing = FRAMES_TOGETHER, 0
    done = np.clip((np.arange(frames) - standing) / max(1, frames - 1 - standing), 0, 1)
    done = done ** rng.uniform(0.9, 1.4)
    drift = rng.uniform(*line.habits.drift)
    steepness = rng.uniform(1.5, 4)
    x_mm, yaw_deg = rng.normal(0, 0.12) * line.radius_mm, rng.normal(0, 0.8)
    shake_mm = line.shake_px / line.radius_px()[0] * line.radius_mm
    tongs = int(rng.integers(1, 4) * rng.integers(2))  # frames in which they rise

    def sight(state: State, number: int, way: float, heating: float) -> Sight:
        shake_x, shake_z = rng.normal(0, shake_mm, 2)
        y_mm = way * line.travel_mm - behind_mm
        pose = Pose((x_mm + shake_x, y_mm, ingot.radius_mm + shake_z), yaw_deg)
        rise_mm = (1 + number) ** 2 * 0.8 * line.radius_mm if number < tongs else float("inf")
        return Sight(ingot, pose, state, heating, rise_mm)

    sights = [
        sight("placed", number, float(way), float(1 + (drift - 1) * way**steepness)) for number, way in enumerate(done)
    ]
    way = 1.0
    for step in LEAVING_STEPS:
        way += step + behind_mm / line.travel_mm / len(LEAVING_STEPS)
        sights.append(sight("leaving", frames, way, drift))
    return sights


def _glare(line: IngotLine, rng: Rng, track: list[Sight], start: int) -> tuple[Glare | None, range]:
    """Glare near one ingot for a part of its way, and the frames in which it is there."""
    happens, touches = rng.random(2) < (line.habits.glare_share, line.habits.touching_share)
    glare = _random_glare(line, rng)
    first = start + int(rng.integers(len(track) // 2))
    frames = range(first, first + int(rng.integers(6, 30)))
    if not happens:
        return None, range(0)
    if touches:
        middle = track[min(len(track) - 1, frames[len(frames) // 2] - start)]
        x_mm, y_mm, _ = middle.pose.end_mm
        side = rng.choice([-1, 1])
        width, depth = glare.size_mm
        beside = x_mm + side * (0.75 * line.radius_mm + 0.6 * width)
        glare = Glare((beside, y_mm + rng.uniform(-0.2, 0.6) * depth), *_rest(glare))
    return glare, frames


def _rest(glare: Glare) -> tuple[tuple[float, float], float, float, int]:
    return glare.size_mm, glare.level, glare.warmth, glare.seed


def _random_glare(line: IngotLine, rng: Rng) -> Glare:
    radius = line.radius_mm
    return Glare(
        (rng.uniform(-1.5, 1.5) * radius, rng.uniform(-0.5, 1.3) * line.travel_mm),
        (rng.uniform(0.4, 1.4) * radius, rng.uniform(0.5, 3) * radius),
        rng.uniform(0.5, 1.6),
        rng.choice([0.0, rng.uniform(0, 0.6)]),
        int(rng.integers(1 << 31)),
    )


def _overexposure(line: IngotLine, rng: Rng, track: list[Sight], start: int) -> tuple[float, range]:
    """How many times too much light, and the frames in which it is too much: placed ones, at least half of them."""
    happens = rng.random() < line.habits.overexposed_share
    factor = rng.uniform(*OVEREXPOSURE)
    placed = [number for number, sight in enumerate(track) if sight.state == "placed"]
    if not happens or not placed:
        return 1.0, range(0)
    first, last = placed[0] + start, placed[-1] + start
    begin = first + int(rng.integers(0, max(1, len(placed) // 2)))
    return factor, range(begin, min(last + 1, begin + int(rng.integers(10, 30))))


def _without_ingots(line: IngotLine, rng: Rng, ingots: int | None) -> Iterator[Moment]:
    """The empty line, as long as it would take some ingots to pass, with or without glare."""
    number = 0
    while ingots is None or number < ingots:
        yield from (Moment() for _ in range(int(rng.integers(3, 12))))
        glare = _random_glare(line, rng) if rng.random() < line.habits.glare_share else None
        yield from (Moment(glare=glare) for _ in range(int(rng.integers(25, 45))))
        number += 1
