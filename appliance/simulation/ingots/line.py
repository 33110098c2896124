"""An ingot line as it is drawn from a seed: its camera, its usual ingot, what a recording of it is told."""

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars.bars import levels
from appliance.simulation.ingots.cast_faces import cast_face
from appliance.simulation.ingots.faces import TYPICAL, Label, Looks, Rng, face, random_looks, side
from appliance.simulation.ingots.foreign_faces import foreign_face
from appliance.simulation.ingots.solid import Ingot, Pose, end_circle_px, outline_px
from appliance.simulation.response import Response
from appliance.simulation.sensor import Blur, Light, Sensor
from appliance.simulation.true_rig import TrueCamera, look_at

Box = tuple[int, int, int, int]  # x, y, width, height, pixels
Range = tuple[float, float]
FaceKind = Literal["own", "foreign", "cast"]

IMAGE_SIZE = (960, 540)
RADIUS_PX: Range = (35.0, 62.0)  # of an end that has just been set down, in a picture 960 pixels wide
HOTTER_C = 12.0  # half the range of the ingots' temperatures
RESPONSES: tuple[Response, ...] = ("srgb", "gamma 2.2")


@dataclass(frozen=True, slots=True)
class Habits:
    """What happens on a line, to one ingot after the other.

    Attributes
    ----------
    ingots : bool
        Whether any come.
    set_down : bool
        Whether the crane sets them down; otherwise it lets them hang over the line and takes them away.
    glare_share, touching_share, overexposed_share : float
        Of the ingots: those beside which a glare appears, those of them that it borders, those during which the
        camera is overexposed.
    drift : tuple of float
        Range of how many times brighter an ingot is when it reaches the rolls.
    in_view : int
        Ingots on the line at the same time.
    faces : {"own", "foreign", "cast"}
        Whose ends they are, those of the references too: our mill's (`faces.py`), others' (`foreign_faces.py`), or
        drawn as their geometry shows them (`cast_faces.py`).
    """

    ingots: bool = True
    set_down: bool = True
    glare_share: float = 0.35
    touching_share: float = 0.5
    overexposed_share: float = 0.2
    drift: Range = (1.0, 1.35)
    in_view: int = 1
    faces: FaceKind = "own"


@dataclass(frozen=True, slots=True, eq=False)
class IngotLine:
    """Everything that decides a sequence's pictures.

    Attributes
    ----------
    seed : int
    camera : TrueCamera
        As it was when the regions and references were made.
    radius_mm, length_mm : float
        Of the usual ingot.
    travel_mm : float
        From where ingots are set down, y = 0, to where they start to leave.
    temperature_c : float
    white : ndarray of float32, shape (3,)
        Gains of blue, green and red, exposure included.
    brightness : float
        Of the hall's lamps.
    veil : float
        Light that haze adds everywhere, over full scale.
    shake_px : float
        Standard deviation of an ingot's trembling.
    sensor, blur : Sensor, Blur
    bloom : float
        Part of the light that spreads over some ten pixels.
    quality : int
        Of the pictures as JPEG.
    habits : Habits
    turned_deg : tuple of float
        How far the camera has turned since, about its own x, y and z axis.
    gain : float
        Exposure now over that at which the references were made.
    """

    seed: int
    camera: TrueCamera
    radius_mm: float
    length_mm: float
    travel_mm: float
    temperature_c: float
    white: NDArray[np.float32]
    brightness: float
    veil: float
    shake_px: float
    sensor: Sensor
    blur: Blur
    bloom: float
    quality: int
    habits: Habits = field(default_factory=Habits)
    turned_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gain: float = 1.0

    def ingot(self, label: Label, rng: Rng, looks: Looks | None = None) -> Ingot:
        """An ingot of this line, with a pattern of its own.

        Its radius differs by up to 3 %, its length by up to 10 %, and its side sends 75 to 102 % of its end's light.
        """
        return Ingot(
            label,
            self.radius_mm * rng.uniform(0.97, 1.03),
            self.length_mm * rng.uniform(0.9, 1.1),
            self.temperature_c + rng.uniform(-HOTTER_C, HOTTER_C),
            self._face(label, rng, looks),
            side(rng) * np.float32(rng.uniform(0.75, 1.02)),
        )

    def _face(self, label: Label, rng: Rng, looks: Looks | None) -> Light:
        match self.habits.faces:
            case "own":
                return face(looks or random_looks(label, rng), rng)
            case "foreign":
                return foreign_face(label, rng)
            case "cast":
                return cast_face(label, rng)

    def typical_ingot(self, label: Label, rng: Rng) -> Ingot:
        """An ingot whose face shows its kind as most do."""
        return self.ingot(label, rng, TYPICAL[label])

    def place(self, y_mm: float, x_mm: float = 0.0, yaw_deg: float = 0.0) -> Pose:
        """Pose on the rollers."""
        return Pose((x_mm, y_mm, self.radius_mm), yaw_deg)

    def roi_crop(self) -> Box:
        """Region in which whole ingots can be seen, from the first place on the line to just before they leave."""
        return self._box(1.3, 0.8, 1.2, include_body=True)

    def roi_centroid(self) -> Box:
        """Region in which the centroid of an ingot on the line lies."""
        return self._box(1.0, 1.0, 0.7, include_body=False)

    def radius_px(self) -> Range:
        """Half widths of the end where ingots are set down and where they leave."""
        first, last = (end_circle_px(self.camera, self._usual(), self.place(y))[2] for y in (0.0, self.travel_mm))
        return first, last

    def document(self) -> dict[str, object]:
        """`roi.json`."""
        return {
            "image": list(self.camera.image_size),
            "roi_crop": list(self.roi_crop()),
            "roi_centroid": list(self.roi_centroid()),
            "radius_px": [round(radius, 1) for radius in self.radius_px()],
            "box": "x, y, width, height",
        }

    def _usual(self) -> Ingot:
        plain = np.ones((2, 2), np.float32)
        return Ingot("bottom", self.radius_mm, self.length_mm, self.temperature_c, plain, plain)

    def _box(self, beside: float, above: float, below: float, *, include_body: bool) -> Box:
        """Box around the way of the usual ingot (or of its end's centre), widened by parts of its radius."""
        usual = self._usual()
        poses = [self.place(0.0), self.place(self.travel_mm)]
        if include_body:
            points = np.concatenate([outline_px(self.camera, usual, pose) for pose in poses])
        else:
            points = np.array([end_circle_px(self.camera, usual, pose)[:2] for pose in poses])
        radius = self.radius_px()[1]
        low = points.min(axis=0) - radius * np.array([beside, above])
        high = points.max(axis=0) + radius * np.array([beside, below])
        columns, rows = self.camera.image_size
        left, right = np.clip([low[0], high[0]], 0, columns).astype(int).tolist()
        top, bottom = np.clip([low[1], high[1]], 0, rows).astype(int).tolist()
        return left, top, right - left, bottom - top


def random_line(seed: int, habits: Habits, image_size: tuple[int, int] = IMAGE_SIZE) -> IngotLine:
    """The line that belongs to a seed; habits that differ in drift change its exposure, nothing else changes.

    Ingots have a radius of 170 to 330 mm and are set down 22 to 42 radii from the camera, which looks down by 13 to 25
    degrees; they travel 10 to 20 % of that distance, and their body shows above the end by 30 to 85 % of the
    diameter. They are of 1030 to 1180 degrees C, and the hottest sends 60 to 92 % of full scale in red. The lamps'
    brightness is 0.4 to 2.5, the veil 0.3 to 3 %, k1 -0.06 to 0.02. The picture shakes by up to 0.3 px, its blur is
    0.7 to 1.5 px with a halo of 3 to 8 px and 0.5 to 3 %, it blooms by 0.5 to 4 %, and is coded with a JPEG quality
    of 78 to 95.
    """
    rng = np.random.default_rng([seed, 0x696E])
    columns, rows = image_size
    radius_mm = rng.uniform(170, 330)
    distance_mm = radius_mm * rng.uniform(22, 42)
    elevation = math.radians(rng.uniform(13, 25))
    visible = rng.uniform(0.3, 0.85)  # of the diameter that the body shows above the end
    travel_mm = distance_mm * rng.uniform(0.1, 0.2)
    radius_px = rng.uniform(*RADIUS_PX) * columns / IMAGE_SIZE[0]
    focal_px = radius_px / radius_mm * distance_mm
    height_mm = radius_mm + distance_mm * math.sin(elevation)
    centre_mm = np.array([rng.normal(0, 0.2) * radius_mm, distance_mm * math.cos(elevation), height_mm])
    # the middle of the way lies near the picture's middle
    aim_mm = np.array([rng.normal(0, 0.4), 0.0, rng.normal(0.3, 0.5)]) * radius_mm
    aim_mm += np.array([0.0, 0.5 * travel_mm, radius_mm])
    camera = TrueCamera(
        np.array([[focal_px, 0, 0.5 * columns], [0, focal_px, 0.5 * rows], [0, 0, 1.0]]),
        np.array([rng.uniform(-0.06, 0.02), 0.0, 0.0, 0.0, 0.0]),
        *look_at(centre_mm, aim_mm, math.radians(rng.normal(0, 0.8))),
        image_size,
    )
    temperature_c = rng.uniform(1030, 1180)
    peak = rng.uniform(0.6, 0.92)  # of red over full scale: a hot ingot near the rolls
    hottest = levels(temperature_c + HOTTER_C) * habits.drift[1]
    white = rng.uniform((0.25, 0.5, 1.0), (0.9, 1.0, 1.0)) * peak / hottest[2]
    return IngotLine(
        seed=seed,
        camera=camera,
        radius_mm=radius_mm,
        length_mm=2 * radius_mm * visible / math.sin(elevation),
        travel_mm=travel_mm,
        temperature_c=temperature_c,
        white=white.astype(np.float32),
        brightness=math.exp(rng.uniform(math.log(0.4), math.log(2.5))),
        veil=float(rng.choice([0.003, rng.uniform(0.003, 0.03)])),
        shake_px=rng.uniform(0.0, 0.3),
        sensor=Sensor(
            RESPONSES[rng.integers(len(RESPONSES))], float(rng.uniform(2_500, 12_000)), float(rng.uniform(8, 30))
        ),
        blur=Blur(float(rng.uniform(0.7, 1.5)), float(rng.uniform(3, 8)), float(rng.uniform(0.005, 0.03))),
        bloom=rng.uniform(0.005, 0.04),
        quality=int(rng.integers(78, 96)),
        habits=habits,
    )
