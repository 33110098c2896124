"""A planned mounting of the two sizing cameras: geometry and optics. Pure arithmetic of the thin lens."""

import math
from typing import NamedTuple

AIM_HEIGHT_MM = 120.0  # over the rollers, at which both cameras look; as the simulated mill's own rigs
SHARP_PX = 1.0  # chosen: circle of confusion; the simulated mill's lens blurs an edge by 0.7 px (k = 1)


class Mounting(NamedTuple):
    """Cameras, lenses and where they stand.

    Attributes
    ----------
    columns, rows : int
        Pixels of a sensor.
    pixel_um : float
        Side of a pixel.
    focal_mm : float
    f_number : float
    distance_mm : float
        From each camera to the middle of the measuring region, `AIM_HEIGHT_MM` over the rollers.
    baseline_mm : float
        Between the two cameras, across the line.
    elevation_deg : float
        Of the cameras over the line, seen from the middle of the region.
    exposure_us : float
    speed_m_s : float
        Of the bar along the line.
    """

    columns: int
    rows: int
    pixel_um: float
    focal_mm: float
    f_number: float
    distance_mm: float
    baseline_mm: float
    elevation_deg: float
    exposure_us: float
    speed_m_s: float

    @property
    def focal_px(self) -> float:
        """Image distance over the side of a pixel; lenses are focused at the region."""
        image_mm = self.focal_mm * self.distance_mm / (self.distance_mm - self.focal_mm)
        return 1000 * image_mm / self.pixel_um

    @property
    def cameras_mm(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Places of the left and the right camera: across the line, along it, over the rollers."""
        reach_mm = math.sqrt(self.distance_mm**2 - self.baseline_mm**2 / 4)
        elevation, half_mm = math.radians(self.elevation_deg), self.baseline_mm / 2
        y_mm, z_mm = -reach_mm * math.cos(elevation), AIM_HEIGHT_MM + reach_mm * math.sin(elevation)
        return (-half_mm, y_mm, z_mm), (half_mm, y_mm, z_mm)

    @property
    def pixel_mm(self) -> float:
        """Length at the region that one pixel shows, at a right angle to the view, mm."""
        return self.distance_mm / self.focal_px

    @property
    def view_mm(self) -> tuple[float, float]:
        """Width and height of what a picture shows at the region, mm."""
        return self.columns * self.pixel_mm, self.rows * self.pixel_mm

    @property
    def angle_deg(self) -> float:
        """Angle between the two views at the region."""
        return math.degrees(2 * math.asin(self.baseline_mm / 2 / self.distance_mm))

    @property
    def depth_of_field_mm(self) -> tuple[float, float]:
        """Nearest and farthest distance at which a point is blurred by less than SHARP_PX; the farthest may be inf.

        Near u H / (H + u), far u H / (H - u) with the hyperfocal distance H = f^2 / (N c), u the distance, N the
        f-number, c the circle of confusion; both from f in front of the lens.
        """
        hyperfocal_mm = self.focal_mm**2 / (self.f_number * SHARP_PX * self.pixel_um / 1000)
        from_focus_mm = self.distance_mm - self.focal_mm
        near_mm = self.distance_mm * hyperfocal_mm / (hyperfocal_mm + from_focus_mm)
        if from_focus_mm >= hyperfocal_mm:
            return near_mm, math.inf
        return near_mm, self.distance_mm * hyperfocal_mm / (hyperfocal_mm - from_focus_mm)

    @property
    def motion_blur_px(self) -> float:
        """Way of the bar along the line within an exposure, in pixels; it does not move the edges across."""
        return self.exposure_us * 1e-3 * self.speed_m_s / self.pixel_mm

    @property
    def exposure_max_us(self) -> float:
        """Longest exposure within which the bar moves by one pixel at most; inf for a bar that stands still."""
        return math.inf if self.speed_m_s == 0 else 1e3 * self.pixel_mm / self.speed_m_s
