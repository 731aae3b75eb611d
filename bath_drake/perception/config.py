"""What is made of the images, as a schema for scenario files."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from bath_drake.perception.given_areas import check_polygon
from bath_drake.perception.map_follower import MAP_FOLLOWERS, MapFollower
from bath_drake.perception.onnx_segmenter import MASKS
from bath_drake.perception.segmentation import SegmentationConfig

SOURCES = ("camera", "ideal")
SEGMENTERS = ("classic", "neural", "neural_any_light")
_RANGES = {
    "camera_rate": (1.0, 60.0),
    "patch_radius": (0.005, 0.1),
    "area_margin": (0.0, 0.2),
}


@dataclass(kw_only=True)
class PerceptionConfig:
    """What is made of the images; `perception: ideal` is short for that source."""

    SHORTHAND: ClassVar[str] = "source"

    # camera: images are rendered and looked at. ideal: the true back, in their stead.
    source: str = "camera"
    camera_rate: float = 30.0  # Hz
    # m, W: where a person's back may be; the Cartesian filter.
    workspace_low: list[float] = field(default_factory=lambda: [0.4, -0.6, 0.4])
    workspace_high: list[float] = field(default_factory=lambda: [1.2, 0.6, 1.6])
    # What tells skin from the rest: classic (colour), neural (colour, on a person),
    # neural_any_light (on a person), or the path of an .onnx file.
    segmenter: str = "classic"
    onnx_mask: str = "skin"  # what such a file's mask is of: skin, or a whole person
    # tracked: carried along with the skin; affine: the box around each frame's mask.
    canonical_map: str = "tracked"
    body_rim: bool = True  # whether the seen back's rim bounds the field
    patch_radius: float = 0.03  # m, of the quadric fit
    # m, added around a restricted area: the jet's radius and the loop's error.
    area_margin: float = 0.02
    # Polygons of canonical corners [x, y] that the carer wants kept off.
    restricted_areas: list[list[list[float]]] = field(default_factory=list)


def check_perception(config: PerceptionConfig) -> None:
    """Raises ValueError naming the key that is out of its range."""
    for key, (low, high) in _RANGES.items():
        value = getattr(config, key)
        if not low <= value <= high:
            raise ValueError(f"{key}: found {value}, allowed {low} to {high}")
    for key, allowed in (
        ("source", SOURCES),
        ("onnx_mask", MASKS),
        ("canonical_map", tuple(MAP_FOLLOWERS)),
    ):
        found = getattr(config, key)
        if found not in allowed:
            raise ValueError(
                f"{key}: found {found[:60]!r}, allowed {', '.join(allowed)}"
            )
    if not (config.segmenter in SEGMENTERS or config.segmenter.endswith(".onnx")):
        raise ValueError(
            f"segmenter: found {config.segmenter[:60]!r}, "
            f"allowed {', '.join(SEGMENTERS)}, or a file that ends in .onnx"
        )
    for k, corners in enumerate(config.restricted_areas):
        try:
            check_polygon(corners)
        except ValueError as error:
            raise ValueError(f"restricted_areas: polygon {k + 1}: {error}") from error
    try:
        segmentation(config)
    except ValueError as error:
        raise ValueError(f"workspace: {error}") from error


def segmentation(config: PerceptionConfig) -> SegmentationConfig:
    """Returns the segmenter's settings; ValueError if the workspace is empty."""
    return SegmentationConfig(
        box_low_W=np.array(config.workspace_low),
        box_high_W=np.array(config.workspace_high),
    )


def map_follower(config: PerceptionConfig) -> MapFollower:
    """Returns how the canonical map is found."""
    return MAP_FOLLOWERS[config.canonical_map]()
