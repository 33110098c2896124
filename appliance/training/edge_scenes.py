"""Pictures with known edges for training the shipped edge forest: scenes of the mill, and random shapes.

Edges are the limbs and ends of a bar, the outline of a post before it, and the visible outlines of rollers, barriers
and clutter. No edges, however steep, are patches of scale, uneven cooling, texture, reflections, glare, haze, and blots
darker than their ground.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars import background
from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.disturbances import Post, Side
from appliance.simulation.bars.line_scene import Picture
from appliance.simulation.bars.scene_setup import SIDES, Setup
from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.bars.surface import hits
from appliance.simulation.response import Response, encode
from appliance.simulation.sensor import blurred_step
from appliance.simulation.true_rig import TrueCamera
from vision.edges.forest.training import Example
from vision.light import NamedResponse, decoding_table

DATA_VERSION = "scenes 2"  # to be raised with each change of these pictures

FIRST_SEED = 10_000_000  # training draws seeds from here on, studies and tests below
PICTURE_SIZE = (560, 420)
CROP_PX = 160
CROPS_PER_PICTURE = 6  # chosen
SHAPES_SHARE = 0.3  # chosen: share of random shapes in all examples
NEAR_LIMB_SHARE = 0.85  # chosen: share of crops of the mill that lie on a limb
UNKNOWN_SEGMENT = -1  # of pixels that no training uses
FIRST_BAR_SEGMENT = 200  # bars are numbered from here on, things of the line below

Image = NDArray[np.float32]
Segments = NDArray[np.int16]
Rng = np.random.Generator

CONDITIONS = {  # chosen: share of the scenes under each condition
    "clean": 0.14,
    "scale": 0.46,
    "rollers": 0.06,
    "post": 0.04,
    "haze": 0.08,
    "glare": 0.08,
    "overexposed": 0.08,
    "bar-end": 0.03,
    "two-bars": 0.03,
}
EFFECTS = ("ovality", "defocus", "jpeg-444", "jpeg-420")
EFFECT_SHARE = 0.15  # chosen: share of scenes with each effect

LEAST_SLOPE = 0.006  # chosen, of full scale per pixel: an outline with less in the blurred picture is invisible
UNSEEN_MARGIN_PX = 2  # chosen: pixels around an invisible outline that are unknown


def edge_examples(seed: int, count: int) -> Iterator[Example]:
    """Render random examples of `CROP_PX` x `CROP_PX` pixels.

    Parameters
    ----------
    seed : int
        The same seed gives the same examples.
    count : int
        Number of examples.

    Yields
    ------
    Example
    """
    rng = np.random.default_rng([seed, 0x6564])
    shapes = round(SHAPES_SHARE * count)
    for _ in range(shapes):
        yield _shapes(rng)
    left = count - shapes
    while left > 0:
        for example in _mill_crops(rng)[:left]:
            yield example
            left -= 1


def _mill_crops(rng: Rng) -> list[Example]:
    """Crops of both pictures of a drawn scene."""
    effects = [name for name in EFFECTS if rng.random() < EFFECT_SHARE]
    condition = str(rng.choice(list(CONDITIONS), p=list(CONDITIONS.values())))
    setup = set_up(condition, FIRST_SEED + int(rng.integers(1 << 31)), PICTURE_SIZE, effects)
    setup = replace(setup, bars=tuple(_more_varied(bar, rng) for bar in setup.bars))
    pair = setup.pair(int(rng.integers(1000)))
    return [crop for side, picture in zip(SIDES, pair, strict=True) for crop in _crops(setup, side, picture, rng)]


def _more_varied(bar: Bar, rng: Rng) -> Bar:
    """Vary the scale of a bar more than the mill's own scenes do.

    Over 5 to 40 % of it, in patches of 15 to 120 mm, 40 to 140 degrees C cooler, uneven by 5 to 30 degrees C.
    """
    if bar.oxide is None:
        return bar
    oxide = replace(
        bar.oxide,
        part=rng.uniform(0.05, 0.4),
        patch_mm=rng.uniform(15, 120),
        cooler_c=rng.uniform(40, 140),
        unevenness_c=rng.uniform(5, 30),
    )
    return replace(bar, oxide=oxide)


def _crops(setup: Setup, side: Side, picture: Picture, rng: Rng) -> Iterator[Example]:
    """Crops of a picture, turned and scaled, mostly around a limb."""
    camera = setup.rig.left if side == "left" else setup.rig.right
    grid = camera.pixel_grid()
    rays = camera.rays(grid)
    parts = background.parts(camera.centre_mm, rays.astype(np.float32), setup.seed)
    bar = setup.bars[int(rng.integers(len(setup.bars)))]
    seen = hits(camera.centre_mm, rays[::4, ::4], bar).seen
    limb = grid[::4, 4::4][seen[:, 1:] != seen[:, :-1]]
    hidden = [_hidden(post, setup) for post in setup.disturbances if isinstance(post, Post) and post.side == side]
    colour = picture[..., ::-1].astype(np.float32) / np.float32(255)
    for _ in range(CROPS_PER_PICTURE):
        places = _places(camera, bar, limb, rng)
        image, *behind = (_resampled(plane, places, cv2.INTER_LINEAR) for plane in (colour, *hidden))
        segments = _resampled(parts.astype(np.float32), places, cv2.INTER_NEAREST).astype(np.int16)
        _paint_bars(segments, setup, camera, places)
        for coverage in behind:
            segments[coverage > 0.5] = FIRST_BAR_SEGMENT - 1
        shown = _as_shown(image, setup.sensor.response, rng)
        yield Example(shown, (_without_invisible(segments, shown),))


def _hidden(post: Post, setup: Setup) -> Image:
    scene = setup.scene_as_calibrated()
    return post.coverage(scene.left if post.side == "left" else scene.right)


def _resampled(plane: Image, places: NDArray[np.float64], how: int) -> Image:
    x, y = np.moveaxis(places.astype(np.float32), -1, 0)
    return np.asarray(cv2.remap(plane, x, y, how), np.float32)


def _paint_bars(segments: Segments, setup: Setup, camera: TrueCamera, places: NDArray[np.float64]) -> None:
    """Write the segment numbers of bars into their pixels, the nearest bar last."""
    rays = camera.rays(places)
    for number, bar in enumerate(sorted(setup.bars, key=lambda bar: -abs(bar.offset_mm - camera.centre_mm[0]))):
        segments[hits(camera.centre_mm, rays, bar).seen] = FIRST_BAR_SEGMENT + number


def _places(camera: TrueCamera, bar: Bar, limb: NDArray[np.float64], rng: Rng) -> NDArray[np.float64]:
    """Positions in the picture of a crop's pixels, shape (CROP_PX, CROP_PX, 2)."""
    size = np.array(camera.image_size)
    near_limb = len(limb) > 0 and rng.random() < NEAR_LIMB_SHARE
    centre = limb[rng.integers(len(limb))] + rng.normal(0, 25, 2) if near_limb else rng.uniform(0, size)
    further, nearer = camera.project(bar.axis_point_mm + np.outer([100.0, 0.0], bar.axis_direction))
    upright = float(np.arctan2(*(further - nearer)[::-1])) - np.pi / 2
    kind = rng.random()
    turn, scale = rng.uniform(-np.pi, np.pi), rng.uniform(0.5, 1.2)
    if kind < 0.5:
        turn = upright + rng.normal(0, 0.05)
    elif kind < 0.75:
        turn, scale = 0.0, 1.0
    reach = scale * CROP_PX / 2 * (abs(np.cos(turn)) + abs(np.sin(turn))) + 1
    centre = np.clip(centre, reach, size - 1 - reach)
    if scale == 1.0:
        centre = np.rint(centre) + 0.5
    offset = np.arange(CROP_PX) - (CROP_PX - 1) / 2
    x, y = np.meshgrid(offset, offset)
    if rng.random() < 0.5:
        x = -x
    if rng.random() < 0.5:
        y = -y
    step = scale * np.array([np.cos(turn), np.sin(turn)])
    return centre + np.stack([x * step[0] - y * step[1], x * step[1] + y * step[0]], axis=-1)


def _as_shown(image: Image, response: Response, rng: Rng) -> Image:
    """The picture in colour, or in one of the greys that edge detectors receive."""
    kind = rng.random()
    if kind < 0.35:
        return image
    brightest = image[..., int(np.argmax(image.mean(axis=(0, 1))))]
    if kind < 0.55:
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.float32)
    if kind < 0.75:
        return brightest
    light = np.interp(brightest, np.linspace(0, 1, 256), decoding_table(cast("NamedResponse", response)))
    return np.asarray(encode(light, "srgb"), np.float32)


def _without_invisible(segments: Segments, image: Image) -> Segments:
    """Segments with `UNKNOWN_SEGMENT` around outlines that cannot be seen."""
    grey = image if image.ndim == 2 else image.max(axis=2)
    smooth = cv2.GaussianBlur(grey, (0, 0), 2.0)
    slope = cv2.magnitude(*(cv2.Sobel(smooth, cv2.CV_32F, dx, 1 - dx, scale=1 / 8) for dx in (1, 0)))
    outline = np.zeros(segments.shape, np.bool_)
    outline[1:] |= segments[1:] != segments[:-1]
    outline[:, 1:] |= segments[:, 1:] != segments[:, :-1]
    around = np.ones((2 * UNSEEN_MARGIN_PX + 1, 2 * UNSEEN_MARGIN_PX + 1), np.uint8)
    hidden = outline & (slope < LEAST_SLOPE)
    return np.where(cv2.dilate(hidden.astype(np.uint8), around) > 0, np.int16(UNKNOWN_SEGMENT), segments)


def _shapes(rng: Rng) -> Example:
    """Textured bands, ellipses and polygons before one another."""
    y, x = np.mgrid[:CROP_PX, :CROP_PX] - (CROP_PX - 1) / 2
    light = _filled(rng, rng.uniform(0.002, 0.3))
    segments = np.zeros((CROP_PX, CROP_PX), np.int16)
    blur_px = rng.uniform(0.5, 1.4)
    for number in range(1, int(rng.integers(2, 7))):
        place = rng.uniform(-0.45, 0.45, 2) * CROP_PX
        is_band = rng.random() < 0.5
        outline = _band if is_band else _patch
        distance = outline(x - place[0], y - place[1], rng)
        level = np.exp(rng.uniform(float(np.log(0.003)), float(np.log(1.2))))
        inside = distance < 0
        is_blot = not is_band and inside.any() and level < light[inside].mean()
        light += blurred_step(-distance / blur_px)[..., None] * (_filled(rng, level, depth_px=-distance) - light)
        if not is_blot:
            segments[inside] = number
    light += np.sqrt(light / rng.uniform(3_000, 20_000) + rng.uniform(0, 0.002) ** 2) * rng.standard_normal(light.shape)
    code = encode(np.clip(light, 0, 1), ("srgb", "srgb", "gamma 2.2", "linear")[int(rng.integers(4))])
    image = (np.rint(255 * code) / 255).astype(np.float32)
    shown = image if rng.random() < 0.4 else image[..., int(rng.integers(3))].copy()
    return Example(shown, (_without_invisible(segments, shown),))


def _band(x: NDArray[np.float64], y: NDArray[np.float64], rng: Rng) -> NDArray[np.float64]:
    """Signed distance to the outline of a band across the origin, negative inside."""
    turn = rng.uniform(0, np.pi)
    return np.abs(x * np.cos(turn) + y * np.sin(turn)) - rng.uniform(4, 70)


def _patch(x: NDArray[np.float64], y: NDArray[np.float64], rng: Rng) -> NDArray[np.float64]:
    """Signed distance to the outline of an ellipse or a polygon around the origin, negative inside."""
    turn = rng.uniform(0, 2 * np.pi)
    if rng.random() < 0.5:
        half = rng.uniform(6, 70, 2)
        across, along = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
        reach = np.hypot(across / half[0], along / half[1])
        slope = np.hypot(across / half[0] ** 2, along / half[1] ** 2) / np.maximum(reach, 1e-6)
        return (reach - 1) / np.maximum(slope, 1e-6)
    sides = turn + np.sort(rng.uniform(0, 2 * np.pi, int(rng.integers(3, 8))))
    far = rng.uniform(8, 60, len(sides))
    return np.max([x * np.cos(side) + y * np.sin(side) - reach for side, reach in zip(sides, far, strict=True)], axis=0)


def _filled(rng: Rng, level: float, depth_px: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
    """Light of a surface, shape (CROP_PX, CROP_PX, 3): colour, slopes, texture, patches, limbs that fade."""
    colour = level * np.exp(rng.normal(0, 0.5, 3))
    if rng.random() < 0.4:
        colour = level * np.array([1.0, rng.uniform(0.25, 0.6), rng.uniform(0.05, 0.25)])  # glowing
    texture = 0.0
    for cells in (3, 8, 24, 64):
        if rng.random() < 0.6:
            texture = texture + rng.uniform(0, 0.25) * _noise(rng, cells)
    surface = np.exp(texture * np.ones((CROP_PX, CROP_PX)))
    if rng.random() < 0.4:
        patches = _noise(rng, int(rng.integers(4, 24))) + 0.3 * _noise(rng, 40)
        edge_px = rng.uniform(0.02, 0.4)
        share = blurred_step((patches - rng.uniform(0, 1.5)) / edge_px)
        surface *= 1 - rng.uniform(0.1, 0.7) * share
    if depth_px is not None and rng.random() < 0.5:
        depth = np.clip(depth_px / max(depth_px.max(), 1e-6), 0, 1)
        surface *= 1 - rng.uniform(0, 0.5) * (1 - np.sqrt(depth * (2 - depth)))
    return surface[..., None] * colour


def _noise(rng: Rng, cells: int) -> NDArray[np.float64]:
    """Smooth noise of mean 0 and standard deviation near 1, with so many cells each way."""
    grid = rng.standard_normal((cells + 3, cells + 3)).astype(np.float32)
    size = CROP_PX * (cells + 3) // cells + 1
    smooth = cv2.resize(grid, (size, size), interpolation=cv2.INTER_CUBIC)
    start = (size - CROP_PX) // 2
    return smooth[start : start + CROP_PX, start : start + CROP_PX].astype(np.float64)
