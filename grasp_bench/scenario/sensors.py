"""Depth cameras: the parameters of the noise model, and presets with their sources.

A scenario takes a preset and changes what it wants to:
``sensor: {preset: azure-kinect, axial_sigma: 0.001}``. The model itself is in
:mod:`grasp_bench.scene.sensor`. A preset is only what a camera adds to a perfect picture; lens and resolution
are the scenario's ``camera``.

Sources of the presets:

* ``femto-w``: range 0.25–2.5 m as listed for Orbbec's Femto W in installers' planning tools. No error
  specification of it was found; noise follows what is used for time-of-flight cameras of its class
  (σ = 0.5 mm + 1 mm/m beyond 0.5 m and a quarter pixel sideways, after Tölgyessy et al., Sensors 2021,
  21(2):413). Edge, grazing and speckle shares are estimates.
* ``azure-kinect``: Microsoft's hardware specification of the mode WFOV 2×2 binned: 0.25–2.88 m, for surfaces
  that reflect 15–95 % at 850 nm, systematic error below 11 mm + 0.1 % of the distance, random error at most
  17 mm, bounds that Tölgyessy et al. confirm. Noise is ``femto-w``'s, whose formula cites them. The 3 mm of
  constant bias are a value inside the bound; the dropout shares on dark and shiny surfaces are estimates.
* ``structured-light``: first-generation Kinect and its PrimeSense relatives. σ = 1.2 mm + 1.9 mm/m² · (d −
  0.4 m)² and 0.8 px sideways (Nguyen, Izadi & Lovell, 3DIMPVT 2012); depth in steps of 2.85 mm/m² · d²
  (Khoshelham & Elberink, Sensors 2012, 12(2):1437); range 0.35–1.4 m of PrimeSense's Carmine 1.09. Such
  cameras lose edges in the projector's shadow rather than mix them; the shares are estimates.
* ``kinect-v1``: ``structured-light`` as the first Kinect's pictures show it: its projector stands 75 mm to
  the right of the camera (Khoshelham & Elberink), its windows lose what is thin, range 0.4–3 m, and it
  measures little on what is dark or shiny.
* ``stereo``: active stereo of the class of RealSense's D435: σ = d² · s/(f · b) with a subpixel error s of
  0.08 px, f = 640 px and a baseline b of 50 mm, which is 2.5 mm/m² (the formula is that of Intel's notes on
  tuning such cameras), the second eye's shadow, windows, and holes where nothing varies (an estimate).
* ``time-of-flight``: ``azure-kinect`` with more flying pixels and with light that comes by way of nearer
  things: up to 3 cm too far beside walls, the order that Sarbolandi, Lefloch & Kolb, CVIU 2015, find;
  strength and reach are estimates.
* ``ideal``: the perfect picture.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, get_args

from pydantic import Field, model_validator

from grasp_bench.scenario.fields import Fraction, NonNegative, Positive, Section

Preset = Literal[
    "azure-kinect", "femto-w", "ideal", "kinect-v1", "stereo", "structured-light", "time-of-flight"
]
PRESET_NAMES: tuple[str, ...] = get_args(Preset)


class Sensor(Section):
    """Noise of an RGB-D camera; see :mod:`grasp_bench.scene.sensor` for the model of each term.

    Values that are not given are those of ``preset``. Lengths are metres, ``_px`` are pixels, ``_deg``
    degrees, shares and probabilities 0 to 1, colours of 255.
    """

    preset: Preset = "femto-w"
    axial_sigma: NonNegative = 0.0005
    axial_sigma_per_metre: NonNegative = 0.001
    axial_sigma_per_metre2: NonNegative = 0.0
    axial_onset: NonNegative = 0.5
    bias: float = 0.0
    bias_per_metre: float = 0.0
    depth_step_per_metre2: NonNegative = 0.0
    lateral_sigma_px: NonNegative = 0.25
    mixed_pixels: Fraction = 0.5
    edge_step: Positive = 0.01
    edge_dropout: Fraction = 0.25
    grazing_angle_deg: Annotated[float, Field(ge=0, le=90)] = 80.0
    grazing_dropout: Fraction = 0.5
    dark_albedo: Annotated[float, Field(gt=0, le=1)] = 0.15
    dark_dropout: Fraction = 0.0
    shiny_roughness: Annotated[float, Field(gt=0, le=1)] = 0.4
    shiny_dropout: Fraction = 0.0
    distant_onset: NonNegative = 1.5
    distant_dropout: Fraction = 0.0
    patch_px: Annotated[int, Field(ge=1, le=64)] = 6
    speckle_dropout: Fraction = 0.001
    minimum_range: NonNegative = 0.25
    maximum_range: Positive = 2.5
    projector_baseline: Annotated[float, Field(ge=-0.5, le=0.5)] = 0.0
    window_px: Annotated[int, Field(ge=0, le=4)] = 0
    multipath: NonNegative = 0.0
    multipath_reach_px: Positive = 24.0
    textureless_dropout: Fraction = 0.0
    filled: bool = False
    frames: Annotated[int, Field(ge=1, le=64)] = 1
    rgb_sigma: NonNegative = 2.0
    rgb_shot_noise: NonNegative = 0.0
    exposure: Positive = 1.0
    exposure_sigma: NonNegative = 0.0
    white_balance: tuple[Positive, Positive, Positive] = (1.0, 1.0, 1.0)
    white_balance_sigma: NonNegative = 0.0
    auto_exposure: Fraction = 0.0
    rgb_blur_px: Annotated[float, Field(ge=0, le=10)] = 0.0
    jpeg_quality: Annotated[int, Field(ge=0, le=100)] = 0

    @model_validator(mode="before")
    @classmethod
    def _complete(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        preset = given.get("preset", "femto-w")
        return PRESETS.get(preset, {}) | given if isinstance(preset, str) else given

    @model_validator(mode="after")
    def _consistent(self) -> Sensor:
        if self.minimum_range >= self.maximum_range:
            raise ValueError("minimum_range must be below maximum_range")
        if self.distant_dropout and self.distant_onset >= self.maximum_range:
            raise ValueError("distant_onset must be below maximum_range")
        return self


# fmt: off
PRESETS: dict[str, dict[str, Any]] = {
    "femto-w": {},
    "ideal": {
        "axial_sigma": 0.0, "axial_sigma_per_metre": 0.0, "lateral_sigma_px": 0.0, "mixed_pixels": 0.0,
        "edge_dropout": 0.0, "grazing_dropout": 0.0, "speckle_dropout": 0.0, "minimum_range": 0.0,
        "maximum_range": 10.0, "rgb_sigma": 0.0},
    "kinect-v1": {
        "axial_sigma": 0.0012, "axial_sigma_per_metre": 0.0, "axial_sigma_per_metre2": 0.0019,
        "axial_onset": 0.4, "depth_step_per_metre2": 0.00285, "lateral_sigma_px": 0.8, "mixed_pixels": 0.05,
        "edge_dropout": 0.6, "grazing_angle_deg": 75.0, "dark_albedo": 0.02, "dark_dropout": 0.9,
        "shiny_dropout": 0.6, "distant_onset": 2.0, "distant_dropout": 0.2, "minimum_range": 0.4,
        "maximum_range": 3.0, "rgb_shot_noise": 0.03, "projector_baseline": 0.075, "window_px": 1},
    "stereo": {
        "axial_sigma": 0.0003, "axial_sigma_per_metre": 0.0, "axial_sigma_per_metre2": 0.0025,
        "axial_onset": 0.0, "lateral_sigma_px": 0.5, "mixed_pixels": 0.3, "edge_dropout": 0.3,
        "shiny_dropout": 0.3, "distant_dropout": 0.0, "maximum_range": 5.0, "rgb_shot_noise": 0.03,
        "projector_baseline": -0.05, "window_px": 1, "textureless_dropout": 0.04, "patch_px": 10},
    "time-of-flight": {
        "bias": 0.003, "bias_per_metre": 0.001, "mixed_pixels": 0.8, "edge_dropout": 0.1,
        "dark_albedo": 0.05, "dark_dropout": 0.6, "shiny_dropout": 0.3, "maximum_range": 4.0,
        "rgb_shot_noise": 0.03, "multipath": 0.1},
    "azure-kinect": {
        "bias": 0.003, "bias_per_metre": 0.001, "dark_dropout": 0.5, "shiny_dropout": 0.3,
        "distant_onset": 2.3, "distant_dropout": 0.3, "maximum_range": 2.88, "rgb_shot_noise": 0.03},
    "structured-light": {
        "axial_sigma": 0.0012, "axial_sigma_per_metre": 0.0, "axial_sigma_per_metre2": 0.0019,
        "axial_onset": 0.4, "depth_step_per_metre2": 0.00285, "lateral_sigma_px": 0.8, "mixed_pixels": 0.1,
        "edge_dropout": 0.6, "dark_dropout": 0.4, "shiny_dropout": 0.5, "distant_onset": 1.0,
        "distant_dropout": 0.2, "minimum_range": 0.35, "maximum_range": 1.4, "rgb_shot_noise": 0.03},
}
# fmt: on
"""What each preset changes against the defaults, which are ``femto-w``'s."""
