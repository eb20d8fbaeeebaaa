"""How synthetic scenes are drawn: ranges and shares, and presets of them.

A range is (least, greatest) and drawn from uniformly; a share is the chance of something.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError, model_validator

from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.scenario.faults import fault_lines
from grasp_bench.scenario.fields import Fraction, NonNegative, Section
from grasp_bench.scenario.sensors import Preset
from grasp_bench.system.files import read_text
from grasp_bench.system.yaml_text import read_yaml

Range = tuple[float, float]


class CameraStyle(Section):
    """Where the camera stands.

    Attributes:
        height: above the table [m].
        tilt_deg: of the view from the vertical.
        straight: share of scenes seen from straight above, whatever ``tilt_deg`` says.
        roll_deg: about the view.
        fov_deg: horizontal field of view.
        off_centre: how far from the table's middle it looks, along x and y [m].
        pixels_per_metre: of the table's middle as stored; drawn by its logarithm. Camera pictures are as wide
            as it takes, so that heights and fields of view that go with no width in ``width`` are drawn anew.
        width: of the camera's picture [px]; it is 3/4 as high.
        detrended: share of tilted views that stay as they are but for their depth, from which the table's
            surface is taken as it is from real data sets' (:mod:`grasp_bench.predictors.tabletop`). The
            others are turned face on as in trials (:mod:`grasp_bench.predictors.level`).
    """

    height: Range = (0.4, 1.2)
    tilt_deg: Range = (0.0, 45.0)
    straight: Fraction = 0.25
    roll_deg: Range = (-20.0, 20.0)
    fov_deg: Range = (45.0, 90.0)
    off_centre: NonNegative = 0.06
    pixels_per_metre: Range = (260.0, 900.0)
    width: Range = (340.0, 900.0)
    detrended: Fraction = 0.6


class SurroundingsStyle(Section):
    """What stands around, each a share of the scenes.

    Attributes:
        wall: a wall, mostly on the far side; ``corner`` of these have another beside it.
        wall_distance: of a wall from the table's middle, in halves of the stored picture's side.
        same_color: share of walls painted as the table.
        edge: the table ends near the objects on one to three sides.
        edge_distance: of these sides from the table's middle, in the same unit.
        bin, tray: high and low rims around the objects.
        shelf: boards on posts behind, with things on them.
        things: other things at the picture's edge and behind.
        large: things too wide to be grasped.
        robot: links of an arm in the picture.
        flat: sheets of paper, cables and stickers on the table.
    """

    wall: Fraction = 0.6
    corner: Fraction = 0.3
    wall_distance: Range = (0.5, 1.3)
    same_color: Fraction = 0.4
    edge: Fraction = 0.4
    edge_distance: Range = (0.4, 1.4)
    bin: Fraction = 0.1
    tray: Fraction = 0.08
    shelf: Fraction = 0.1
    things: Fraction = 0.35
    large: Fraction = 0.25
    robot: Fraction = 0.15
    flat: Fraction = 0.3


class DepthStyle(Section):
    """What the depth camera makes of it.

    Attributes:
        presets: relative shares of the sensors.
        strength: factor on their noise and their shares of lost pixels.
        filled: share of pictures whose holes are filled smoothly.
        foreign_origin: share of detrended views whose depth is a distance from a point beside the camera.
    """

    presets: dict[Preset, NonNegative] = Field(
        default={"femto-w": 1, "kinect-v1": 2, "time-of-flight": 1, "stereo": 1, "ideal": 0.3}
    )
    strength: Range = (0.4, 1.6)
    filled: Fraction = 0.4
    foreign_origin: Fraction = 0.6

    @model_validator(mode="after")
    def _consistent(self) -> DepthStyle:
        if not sum(self.presets.values()) > 0:
            raise ValueError("depth.presets: give at least one preset a share above 0")
        return self


class ColourStyle(Section):
    """Light, surfaces and the colour camera.

    Attributes:
        lamps: least and greatest number of lamps.
        ambient: light from everywhere.
        tint: greatest deviation of a lamp's channels from white.
        table_texture, wall_texture, object_texture: shares of textured ones.
        white: share of tables that are nearly white; ``vivid`` of the others have any colour, the rest are
            grey, brown or pale.
        brightness: of the mean picture, by exposure.
        balance: standard deviation of the logarithm of each channel's balance.
        grain: of the colour noise, of 255.
        blur: of the lens [px].
        jpeg: share of pictures that went through JPEG.
        jpeg_quality: its quality.
    """

    lamps: tuple[Annotated[int, Field(ge=1, le=6)], Annotated[int, Field(ge=1, le=6)]] = (1, 3)
    ambient: Range = (0.25, 0.7)
    tint: NonNegative = 0.15
    table_texture: Fraction = 0.5
    wall_texture: Fraction = 0.3
    object_texture: Fraction = 0.4
    white: Fraction = 0.4
    vivid: Fraction = 0.2
    brightness: Range = (0.3, 0.88)
    balance: NonNegative = 0.06
    grain: Range = (0.5, 6.0)
    blur: Range = (0.0, 1.2)
    jpeg: Fraction = 0.5
    jpeg_quality: Range = (40, 95)


class Style(Section):
    """How the scenes of a data set are drawn."""

    camera: CameraStyle = CameraStyle()
    surroundings: SurroundingsStyle = SurroundingsStyle()
    depth: DepthStyle = DepthStyle()
    colour: ColourStyle = ColourStyle()

    @model_validator(mode="before")
    @classmethod
    def _ordered(cls, given: Any) -> Any:
        if isinstance(given, dict):
            for section, values in given.items():
                for key, value in values.items() if isinstance(values, dict) else ():
                    if isinstance(value, list | tuple) and len(value) == 2 and value[0] > value[1]:
                        raise ValueError(f"{section}.{key}: the first must not be above the second")
        return given


PLAIN = "plain"
STYLES: dict[str, Style | None] = {PLAIN: None, "camera-like": Style()}
"""Presets; None draws the reference scenario alone, a little varied."""


def read_style(name: str) -> Style | None:
    """Return a preset by its name, or what a YAML file says; what it leaves out is as in ``camera-like``.

    Raises:
        UnknownNameError: for a name that is neither.
        GraspBenchError: for a file that is missing or holds wrong keys or values.
    """
    if Path(name).suffix not in (".yaml", ".yml"):
        if name not in STYLES:
            raise UnknownNameError("style", name, list(STYLES))
        return STYLES[name]
    try:
        content = read_yaml(read_text(Path(name)))
    except (OSError, ValueError) as error:
        raise GraspBenchError(f"Style {name} cannot be read ({error}).") from error
    try:
        return Style.model_validate(content or {})
    except ValidationError as error:
        raise GraspBenchError("\n".join(fault_lines(error, name, Style))) from error
