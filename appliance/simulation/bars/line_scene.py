"""The simulated line before its cameras: a bar in, two pictures out."""

from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars import background
from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.silhouette import Glow, Silhouette, silhouette
from appliance.simulation.bars.surface import with_details
from appliance.simulation.sensor import Blur, Light, NoiseStock, Sensor
from appliance.simulation.true_rig import TrueCamera, TrueRig

Picture = NDArray[np.uint8]  # of uint16 from a sensor of more than 8 bits

PREPARED = 6  # pictures of the empty line


class Scene:
    """A rig that looks at the line; what stands still is drawn once.

    Parameters
    ----------
    rig : TrueRig
    seed : int
        Background, clutter and noise.
    sensor : Sensor
    blur : Blur
    glow : Glow
    lit_by : Bar or None
        The bar whose glow the line reflects, in every picture.
    """

    def __init__(
        self,
        rig: TrueRig,
        seed: int,
        sensor: Sensor = Sensor(),  # noqa: B008  frozen
        blur: Blur = Blur(),  # noqa: B008
        glow: Glow = Glow(),  # noqa: B008
        *,
        lit_by: Bar | None = None,
    ) -> None:
        self._seed = seed
        columns, rows = rig.left.image_size
        noise = NoiseStock((3, rows, columns), seed)
        self.left, self.right = (
            View(camera, seed, noise=noise, sensor=sensor, blur=blur, glow=glow, lit_by=lit_by)
            for camera in rig.cameras
        )

    def pair(self, bar: Bar | None, frame: int) -> tuple[Picture, Picture]:
        """Left and right picture, blue-green-red, shape (rows, columns, 3); the frame's number chooses the noise."""
        left, right = noise_starts(self._seed, frame)
        return self.left.picture(bar, left), self.right.picture(bar, right)


def noise_starts(seed: int, frame: int) -> tuple[int, int]:
    """Where the noise of a frame's left and right picture is cut from the stock."""
    left, right = np.random.default_rng([seed, frame]).integers(NoiseStock.EXTRA, size=2)
    return int(left), int(right)


class View:
    """What one camera sees.

    Parameters
    ----------
    camera : TrueCamera
    seed : int
        Background.
    noise : NoiseStock
        For pictures of this camera's size.
    sensor, blur, glow : Sensor, Blur, Glow
    lit_by : Bar or None

    Attributes
    ----------
    camera : TrueCamera
    rays : ndarray of float32, shape (rows, columns, 3)
        Unit direction of each pixel's light, world frame.
    background : ndarray of float32, shape (3, rows, columns)
        Linear light of the empty line, blurred; blue, green, red.
    blur : Blur
    """

    def __init__(
        self,
        camera: TrueCamera,
        seed: int,
        *,
        noise: NoiseStock,
        sensor: Sensor,
        blur: Blur,
        glow: Glow,
        lit_by: Bar | None = None,
    ) -> None:
        self.camera = camera
        self.rays = camera.rays(camera.pixel_grid()).astype(np.float32)
        self.blur = blur
        self.background = background.draw(camera.centre_mm, self.rays, seed, blur, lit_by)
        self._glow = glow
        self._noise = noise
        self._sensor = sensor
        self._table = sensor.table()
        self._prepared: list[Picture] = []

    def light(self, bar: Bar | None) -> Light:
        """Linear light before noise, planes blue, green, red, shape (3, rows, columns); 1 is full scale."""
        light = self.background.copy()
        if bar is not None:
            self.add_bar(light, bar)
        return light

    def picture(self, bar: Bar | None, noise_start: int) -> Picture:
        """Picture, blue-green-red, shape (rows, columns, 3).

        Around the bar the noise is drawn for this picture; where nothing moves it is that of one of `PREPARED` pictures
        of the empty line, which saves time.
        """
        prepared = self._empty_line()
        picture = prepared[noise_start % PREPARED].copy()
        seen = None if bar is None else self._seen(bar)
        if bar is not None and seen is not None:
            touched = (slice(None), seen.rows, seen.columns)
            light = self._covered(self.background[touched].copy(), bar, seen)
            light += self._sensor.noise(light) * self._noise.cut(noise_start)[touched]
            picture[touched[1:]] = np.moveaxis(self._digitised(light), 0, 2)
        return picture

    def _empty_line(self) -> list[Picture]:
        if not self._prepared:
            step = NoiseStock.EXTRA // PREPARED
            self._prepared = [self.exposed(self.background, number * step) for number in range(PREPARED)]
        return self._prepared

    def exposed(self, light: Light, noise_start: int) -> Picture:
        """Picture, shape (rows, columns, 3), of linear light as `light` gives it."""
        noise = self._sensor.noise(light) * self._noise.cut(noise_start)
        noise += light
        return cast("Picture", cv2.merge(list(self._digitised(noise))))

    def grey_picture(self, light: Light, noise_start: int) -> Picture:
        """Grey picture of linear light, shape (rows, columns)."""
        return self._digitised(light + self._sensor.noise(light) * self._noise.cut(noise_start)[0])

    def add_bar(self, light: Light, bar: Bar) -> None:
        """Draw a bar over linear light, in place."""
        seen = self._seen(bar)
        if seen is not None:
            touched = (slice(None), seen.rows, seen.columns)
            self._covered(light[touched], bar, seen)

    def _seen(self, bar: Bar) -> Silhouette | None:
        seen = silhouette(self.camera.centre_mm, self.rays, bar, self._glow, self.blur)
        return None if seen is None else with_details(seen, self.camera.centre_mm, self.rays, bar, self.blur)

    @staticmethod
    def _covered(part: Light, bar: Bar, seen: Silhouette) -> Light:
        part *= 1 - seen.coverage
        part += bar.levels.astype(np.float32)[:, None, None] * seen.glow
        return part

    def _digitised(self, light: Light) -> Picture:
        """Code values of linear light, which is overwritten."""
        light *= self._sensor.levels
        np.clip(light, 0, self._sensor.levels, out=light)
        return cast("Picture", self._table[light.astype(np.uint16)])
