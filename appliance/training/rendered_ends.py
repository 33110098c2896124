"""Ends of ingots as pictures of 64 x 64, rendered without a mill: `ingot_relief` trains on them.

They are drawn a line at a time: its camera, the ends that serve as its references, and others. Faces are those of our
own line and of other mills (the third kind of the simulation, `cast_faces.py`, is kept for judging), under more
blemishes still, beside a body and a dark line. Nothing but wrinkled skin depends on the label.
"""

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.ingots.faces import (
    FACE_CELLS,
    LABELS,
    SHARE_OF_SCALED_BOTTOMS,
    TYPICAL,
    Label,
    Rng,
    face,
    random_looks,
)
from appliance.simulation.ingots.foreign_faces import foreign_blemishes, foreign_face, foreign_skin, no_stronger
from appliance.training.blemishes import soft_blemishes
from vision.ingot.classifiers.similarity import SIZE

Plane = NDArray[np.float32]
Picture = NDArray[np.uint8]

SHARE_OF_FOREIGN_LINES = 0.6
SHARE_OF_EQUAL_TOPS = 0.25  # of the lines: their reference shows the pattern of one of their tops
LEAST_VISIBILITY = 0.8  # chosen: least relief of a top's skin, in standard deviations of the camera's noise
CODES_PER_LOG = 60.0  # grey values to one natural logarithm of light, at the usual exposure
SHARE_OF_BADLY_CUT = 0.15  # of the pictures
TRIES = 20
_across = np.linspace(-1, 1, FACE_CELLS, dtype=np.float32)
_x, _y = np.meshgrid(_across, _across)
_columns = np.arange(SIZE, dtype=np.float32)


class RenderedLine(NamedTuple):
    """What one line shows.

    Attributes
    ----------
    references : ndarray of uint8, shape (2, 64, 64)
        Top and bottom.
    ends : ndarray of uint8, shape (n, 64, 64)
    tops : ndarray of bool, shape (n,)
    """

    references: Picture
    ends: Picture
    tops: NDArray[np.bool_]


class Camera(NamedTuple):
    """How a line's camera shows ends.

    Attributes
    ----------
    blur_px : float
        Standard deviation, in pixels of the picture of 64 x 64.
    peak : float
        Light of a usual end over full scale.
    gains : tuple of float
        Red, green, blue.
    noise_codes : float
        Standard deviation.
    coarse_noise : bool
        Whether the noise of neighbours is alike.
    quality : int
        As JPEG; 0: not coded.
    flattening : float
        Of the end, which is seen from above.
    """

    blur_px: float
    peak: float
    gains: tuple[float, float, float]
    noise_codes: float
    coarse_noise: bool
    quality: int
    flattening: float


def random_camera(rng: Rng) -> Camera:
    """A camera of any line.

    Its blur is 0.35 to 1.4 px, its peak 25 to 75 % of full scale, its channels' gains 1 to 1.5, 0.5 to 1 and 0.1 to
    0.6, its noise 0.2 to 2.5 codes; JPEG has a quality of 60 to 95, and ends are seen 88 to 100 % as high as wide.
    """
    return Camera(
        blur_px=math.exp(rng.uniform(math.log(0.35), math.log(1.4))),
        peak=rng.uniform(0.25, 0.75),
        gains=(rng.uniform(1.0, 1.5), rng.uniform(0.5, 1.0), rng.uniform(0.1, 0.6)),
        noise_codes=rng.uniform(0.2, 2.5),
        coarse_noise=bool(rng.random() < 0.6),
        quality=int(rng.integers(60, 96)) if rng.random() < 0.6 else 0,
        flattening=rng.uniform(0.88, 1),
    )


class Mills(NamedTuple):
    """What mills lines are drawn of, and how hard their ends are to tell.

    Attributes
    ----------
    foreign : float
        Share of lines of other mills.
    scaled_bottoms : float
        Share of our own mill's bottoms with large flakes and a recess.
    soft_blemishes : bool
        Whether more blemishes are added than such faces show anyway.
    """

    foreign: float = SHARE_OF_FOREIGN_LINES
    scaled_bottoms: float = SHARE_OF_SCALED_BOTTOMS
    soft_blemishes: bool = True


MILLS = Mills()


def rendered_line(rng: Rng, faces: int, views: int, mills: Mills = MILLS) -> RenderedLine:
    """A line of any mill.

    Parameters
    ----------
    rng : numpy.random.Generator
    faces : int
        Beside the references, half of them tops.
    views : int
        Pictures of each, under other blemishes every time.
    mills : Mills
    """
    camera, foreign = random_camera(rng), bool(rng.random() < mills.foreign)
    drawn = [random_face(LABELS[number % 2], camera, rng, mills, foreign=foreign) for number in range(faces)]
    first = drawn[0].light if rng.random() < SHARE_OF_EQUAL_TOPS else _typical_face("top", rng, foreign=foreign)
    second = _typical_face("bottom", rng, foreign=foreign)
    references = np.array([rendered_end(light, camera, rng) for light in (first, second)])
    shown = [
        one._replace(blemishes=one.blemishes * soft_blemishes(rng)) if mills.soft_blemishes else one
        for one in drawn
        for _ in range(views)
    ]
    ends = np.array([_perhaps_badly_cut(rendered_end(one.light, camera, rng), rng) for one in shown])
    return RenderedLine(references, ends, np.repeat(np.arange(faces) % 2 == 0, views))


def _perhaps_badly_cut(image: Picture, rng: Rng) -> Picture:
    """Some ends cut out by a circle that does not fit, as where glare or a second ingot touches them."""
    if rng.random() > SHARE_OF_BADLY_CUT:
        return image
    scale, (x, y), middle = rng.uniform(0.85, 1.2), rng.normal(0, 2.5, 2), (SIZE - 1) / 2
    moved = np.array([[scale, 0, (1 - scale) * middle + x], [0, scale, (1 - scale) * middle + y]])
    return np.asarray(cv2.warpAffine(image, moved, (SIZE, SIZE), borderMode=cv2.BORDER_REPLICATE), np.uint8)


def _typical_face(label: Label, rng: Rng, *, foreign: bool) -> Plane:
    return foreign_face(label, rng) if foreign else face(TYPICAL[label], rng)


class Face(NamedTuple):
    """What an end shows, as factors of light.

    Attributes
    ----------
    skin : ndarray of float32, shape (FACE_CELLS, FACE_CELLS), or None
        Of a top; a bottom has none.
    blemishes : ndarray of float32, shape (FACE_CELLS, FACE_CELLS)
    """

    skin: Plane | None
    blemishes: Plane

    @property
    def light(self) -> Plane:
        """Relative light; blemishes of a top are never stronger than its skin."""
        return self.blemishes if self.skin is None else no_stronger(self.skin, self.blemishes)


def random_face(label: Label, camera: Camera, rng: Rng, mills: Mills, *, foreign: bool) -> Face:
    """A face on which that camera can see whether it is a top.

    Parameters
    ----------
    label : {"top", "bottom"}
    camera : Camera
    rng : numpy.random.Generator
    mills : Mills
    foreign : bool
        Whether it is another mill's.
    """
    plain = np.ones((FACE_CELLS, FACE_CELLS), np.float32)
    if label == "bottom":
        return Face(
            None, foreign_blemishes(rng) if foreign else face(random_looks(label, rng, mills.scaled_bottoms), rng)
        )
    skin = plain
    for _ in range(TRIES):
        skin = foreign_skin(rng) if foreign else face(random_looks(label, rng, mills.scaled_bottoms), rng)
        if _visibility(skin, camera) > LEAST_VISIBILITY:
            break
    return Face(skin, foreign_blemishes(rng) if foreign else plain)


def _visibility(light: Plane, camera: Camera) -> float:
    """Relief that the camera shows over its noise."""
    cells = FACE_CELLS / SIZE
    codes = np.log(light)
    shown = cv2.GaussianBlur(codes, (0, 0), camera.blur_px * cells) - cv2.GaussianBlur(codes, (0, 0), 6 * cells)
    inside = np.asarray(shown)[np.hypot(_x, _y) < 0.8]
    return CODES_PER_LOG * float(inside.std()) / camera.noise_codes


def rendered_end(light: Plane, camera: Camera, rng: Rng) -> Picture:
    """A picture of an end, as `end_image` would cut it out.

    Four in five are exposed at 0.7 to 1.4 times the camera's peak, the others at 1.4 to 2.3 times, and stray light adds
    up to 4 % of full scale.

    Parameters
    ----------
    light : ndarray of float32, shape (FACE_CELLS, FACE_CELLS)
        Relative light of the face.
    camera : Camera
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of uint8, shape (64, 64)
    """
    scene = _scene(light / max(1e-6, float(light.mean())), camera, rng)
    blur_px = camera.blur_px * rng.uniform(0.85, 1.15)
    scene = np.asarray(cv2.GaussianBlur(scene, (0, 0), blur_px), np.float32)
    peak = camera.peak * (rng.uniform(0.7, 1.4) if rng.random() < 0.8 else rng.uniform(1.4, 2.3))
    return _coded(np.maximum(scene * np.float32(peak) + np.float32(rng.uniform(0, 0.04)), 0), camera, rng)


def _scene(face_light: Plane, camera: Camera, rng: Rng) -> Plane:
    """Light of the face, the body above it and the line around both, with glare beside them."""
    radius = SIZE / 2 * rng.uniform(0.93, 1.06)
    x, y = (SIZE - 1) / 2 + rng.normal(0, 0.8, 2) + np.array([0.0, rng.uniform(-0.03, 0.12) * SIZE / 2])
    across, down = np.broadcast_arrays(
        (_columns[None, :] - x) / radius, (_columns[:, None] - y) / (radius * camera.flattening)
    )
    turn, mirror, half = rng.uniform(0, 2 * np.pi), rng.choice([-1, 1]), (FACE_CELLS - 1) / 2
    map_x = half * (1 + mirror * (across * np.cos(turn) - down * np.sin(turn)))
    map_y = half * (1 + across * np.sin(turn) + down * np.cos(turn))
    smooth = cv2.GaussianBlur(face_light, (0, 0), 1.0)
    shown = cv2.remap(
        smooth, map_x.astype(np.float32), map_y.astype(np.float32), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    rough = np.asarray(cv2.GaussianBlur(rng.standard_normal((SIZE, SIZE)), (0, 0), rng.uniform(1, 5)), np.float64)
    rough = rough / rough.std()
    inside = np.clip(0.5 + (1 - np.hypot(across, down)) * radius, 0, 1)
    body = np.clip(0.5 + (1 - np.abs(across)) * radius, 0, 1) * (down < 0)
    line_light, side_light = rng.uniform(0.01, 0.25) * (1 + 0.4 * rough), rng.uniform(0.65, 1.08) * (1 + 0.05 * rough)
    scene = line_light * (1 - body) + side_light * body
    scene = scene * (1 - inside) + shown * inside
    if rng.random() < 0.4:
        scene = scene + _glare(across, down, 1 - inside if rng.random() < 0.6 else np.ones_like(inside), rng)
    if rng.random() < 0.3:
        bloom = rng.uniform(0.01, 0.08)
        scene = (1 - bloom) * scene + bloom * np.asarray(cv2.GaussianBlur(scene, (0, 0), 6), np.float64)
    return scene.astype(np.float32)


def _glare(
    across: NDArray[np.float64], down: NDArray[np.float64], shown: NDArray[np.float64], rng: Rng
) -> NDArray[np.float64]:
    """A lamp's reflection at or on the end."""
    turn, away = rng.uniform(-0.3, np.pi + 0.3), rng.uniform(0.85, 1.5)
    wide, high, soft = rng.uniform(0.15, 0.8), rng.uniform(0.1, 0.5), rng.uniform(0.05, 0.5)
    place = np.hypot((across - away * np.cos(turn)) / wide, (down - away * np.sin(turn)) / high)
    return rng.uniform(0.3, 2) * shown / (1 + np.exp(np.minimum((place - 1) / soft, 50)))


def _coded(light: Plane, camera: Camera, rng: Rng) -> Picture:
    """Grey of an orange picture whose channels clip one after the other, with noise, perhaps as JPEG."""
    channels = [np.clip(light * gain, 0, 1) ** (1 / 2.2) for gain in camera.gains]
    noise = rng.standard_normal((SIZE, SIZE))
    if camera.coarse_noise:
        noise = 1.8 * cv2.GaussianBlur(noise, (0, 0), 0.6)
    code = 255 * (0.299 * channels[0] + 0.587 * channels[1] + 0.114 * channels[2]) + camera.noise_codes * noise
    picture = np.clip(code, 0, 255).astype(np.uint8)
    if camera.quality:
        _, packed = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, camera.quality])
        picture = np.asarray(cv2.imdecode(packed, cv2.IMREAD_GRAYSCALE), np.uint8)
    return picture
