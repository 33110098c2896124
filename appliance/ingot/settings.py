"""Settings of the ingot station."""

from typing import Self

from pydantic import Field, model_validator

from appliance.black_box.settings import BlackBoxSettings
from appliance.cameras.kinds import IngotCamera
from appliance.cameras.off.settings import NoCamera
from appliance.cameras.settings import LivenessSettings
from appliance.settings.section import Box, FilePath, Section, unit
from vision.ingot.classifiers.names import ClassifierName


class IngotLimits(Section):
    """Limits of size, tilt, length and colour of an ingot's end on the line."""

    radius_min_px: float = Field(
        default=0,
        ge=0,
        le=5000,
        description="Smallest radius of an end; 0: 2 % of the picture's width",
        json_schema_extra=unit("px"),
    )
    radius_max_px: float = Field(
        default=0,
        ge=0,
        le=5000,
        description="Largest radius of an end; 0: 11 % of the picture's width",
        json_schema_extra=unit("px"),
    )
    area_min_px: float = Field(
        default=0,
        ge=0,
        le=100_000_000,
        description="Smallest area of an ingot, in the dissertation 5000; 0: 3.2 squares of the smallest radius",
        json_schema_extra=unit("px"),
    )
    area_max_px: float = Field(
        default=0,
        ge=0,
        le=100_000_000,
        description="Largest area of an ingot, in the dissertation 14000; 0: 7.5 squares of the largest radius",
        json_schema_extra=unit("px"),
    )
    tilt_deg: float = Field(
        default=15.0,
        gt=0,
        le=90,
        description="Largest angle of an ingot from the picture's vertical",
        json_schema_extra=unit("°"),
    )
    length: float = Field(
        default=2.0,
        ge=1,
        le=10,
        description="Longest visible ingot, in diameters of its end; a longer one is being lowered on end",
    )
    arc: float = Field(default=0.6, gt=0, le=1, description="Least visible share of the end's lower half circle")
    red_floor: int = Field(default=100, ge=1, le=254, description="Lowest threshold of the red channel")
    warmth: int = Field(default=30, ge=0, le=254, description="Least difference of red and blue of a hot pixel")


class IngotDecisionSettings(Section):
    """Error probabilities and counts of the sequential test that decides an ingot."""

    false_alarm: float = Field(
        default=0.01,
        gt=0,
        le=49,
        description="Accepted probability that a bottom is called a top",
        json_schema_extra=unit("%"),
    )
    missed: float = Field(
        default=0.1,
        gt=0,
        le=49,
        description="Accepted probability that a top is called a bottom",
        json_schema_extra=unit("%"),
    )
    late_false_alarm: float = Field(
        default=2.0,
        gt=0,
        le=49,
        description="As false_alarm, for an ingot that is still undecided after late_frames",
        json_schema_extra=unit("%"),
    )
    late_missed: float = Field(
        default=20.0,
        gt=0,
        le=49,
        description="As missed, for an ingot that is still undecided after late_frames",
        json_schema_extra=unit("%"),
    )
    late_frames: int = Field(
        default=15,
        ge=2,
        le=10000,
        description="Pictures of an undecided ingot after which the late probabilities apply",
    )
    least_frames: int = Field(default=3, ge=1, le=1000, description="Fewest pictures of an ingot before it is decided")
    still: float = Field(
        default=0.2,
        gt=0,
        le=2,
        description="Largest movement of a resting ingot between two pictures, in radii of its end",
    )
    gone_frames: int = Field(
        default=5,
        ge=1,
        le=1000,
        description="Pictures in a row without an ingot's end after which the ingot counts as gone",
    )


class ComparisonSettings(Section):
    """Structural similarity of an end with the references, eq. 6.1."""

    threshold: float = Field(
        default=0.75, ge=-1, le=1, description="Similarity with the top from which `single` calls an end a top"
    )
    circular: bool = Field(default=False, description="Compare the end's circle; false: the square around it")
    luminance: float = Field(default=1.0, ge=0, le=10, description="Exponent alpha")
    contrast: float = Field(default=1.0, ge=0, le=10, description="Exponent beta")
    structure: float = Field(default=1.0, ge=0, le=10, description="Exponent gamma")

    @model_validator(mode="after")
    def _check_exponents(self) -> Self:
        if self.luminance == self.contrast == self.structure == 0:
            raise ValueError("luminance, contrast, structure: all are 0; give one of them a weight")
        return self


class IngotSettings(Section):
    """The ingot station."""

    camera: IngotCamera = Field(default_factory=NoCamera, description="Where pictures come from")
    references: FilePath | None = Field(
        default=None,
        description="Folder with top.png, bottom.png and perhaps roi.json; not needed for the simulated line",
    )
    classifier: ClassifierName = Field(
        default="relief", description="How one picture is judged; dual and single are those of the dissertation"
    )
    learn: bool = Field(
        default=False,
        description="Keep better references from ingots whose pictures agree, in the folder learned of references",
    )
    comparison: ComparisonSettings = Field(
        default_factory=ComparisonSettings, description="How ends are compared with the references"
    )
    crop: Box = Field(
        default=[], description="Part of the picture in which ingots are searched; []: the part in roi.json"
    )
    centroid: Box = Field(
        default=[], description="Where the middle of an ingot on the line may be; []: the area in roi.json"
    )
    stale_after_ms: int = Field(
        default=2000,
        ge=100,
        le=60000,
        description="Age of the newest picture above which no orientation is served",
        json_schema_extra=unit("ms"),
    )
    memory_max_mb: int = Field(
        default=1024,
        ge=256,
        le=65536,
        description="Memory of the station's process, above which it ends and is started again",
        json_schema_extra=unit("MB"),
    )
    black_box: BlackBoxSettings = Field(
        default_factory=BlackBoxSettings, description="Pictures kept of what led to an alarm"
    )
    liveness: LivenessSettings = Field(default_factory=LivenessSettings, description="When pictures are believed")
    limits: IngotLimits = Field(default_factory=IngotLimits, description="Limits of algorithms 15 and 16")
    decision: IngotDecisionSettings = Field(
        default_factory=IngotDecisionSettings, description="Sequential test over the pictures of an ingot"
    )
