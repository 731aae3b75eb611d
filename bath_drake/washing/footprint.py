"""The skin that a jet or a sponge reaches at one instant.

A jet is a cone of water from the nozzle's tip along its axis: what lies in it, near
enough and turned to the nozzle, is wet (what stands before it is for the caller to ask;
see `bath_drake.washing.washed_places`). Water that runs down or splashes is not
considered. A sponge is a disc square to the tool: what lies under it, while it touches.
"""

import math
from dataclasses import dataclass

import numpy as np

from bath_drake.notation import BoolArray, FloatArray


@dataclass(frozen=True, kw_only=True)
class JetCone:
    """A cone of water.

    Attributes:
        half_angle: Between axis and surface, rad, less than a right angle.
        reach: From the tip, m; further off the water does nothing.

    Raises:
        ValueError: A number is out of its range.
    """

    half_angle: float
    reach: float

    def __post_init__(self) -> None:
        if not 0.0 < self.half_angle < 0.5 * math.pi:
            raise ValueError(
                f"half_angle must be in (0, pi / 2), got {self.half_angle}"
            )
        if not 0.0 < self.reach < math.inf:
            raise ValueError(f"reach must be positive and finite, got {self.reach}")

    @property
    def in_line_of_sight(self) -> bool:
        """Whether what stands between tip and skin keeps the skin dry."""
        return True

    def radius(self, distance: float) -> float:
        """Of the footprint on a plane square to the axis at a distance, m."""
        if distance >= self.reach:
            return 0.0
        within = math.sqrt(self.reach**2 - distance**2)
        return min(distance * math.tan(self.half_angle), within)

    def covers(
        self, points: FloatArray, normals: FloatArray, tip: FloatArray, axis: FloatArray
    ) -> BoolArray:
        """Which places of skin (n, 3) lie in the cone and face the tip, shape (n,).

        Args:
            points: (n, 3) m, in any frame.
            normals: (n, 3) outward ones there, of any length.
            tip: (3,) of the nozzle, m.
            axis: (3,) unit vector along which the water leaves.
        """
        away = points - tip
        along = away @ axis
        distance = np.sqrt((away**2).sum(axis=1))
        inside = along >= math.cos(self.half_angle) * distance
        facing = (away * normals).sum(axis=1) < 0.0
        return np.asarray(inside & facing & (distance <= self.reach))


@dataclass(frozen=True, kw_only=True)
class SpongeDisc:
    """A flat, round sponge at the tool's end.

    Attributes:
        radius: m.
        length: From the tool's tip along its axis to the sponge's face, m, >= 0.
        contact: It touches where a place of skin is this near to the face's middle, m;
            places must be less far apart.

    Raises:
        ValueError: A number is out of its range.
    """

    radius: float
    length: float = 0.0
    contact: float = 0.01

    def __post_init__(self) -> None:
        for name, least in (("radius", 0.0), ("contact", 0.0)):
            value = getattr(self, name)
            if not least < value < math.inf:
                raise ValueError(f"{name} must be positive and finite, got {value}")
        if not 0.0 <= self.length < math.inf:
            raise ValueError(f"length must be finite and >= 0, got {self.length}")

    @property
    def in_line_of_sight(self) -> bool:
        """A sponge lies on the skin: nothing is between."""
        return False

    def covers(
        self, points: FloatArray, normals: FloatArray, tip: FloatArray, axis: FloatArray
    ) -> BoolArray:
        """Which places of skin (n, 3) lie under the disc, shape (n,); see `JetCone`.

        The sponge gives way: once it touches, skin within its rim is under it up to
        half a radius before or behind the face.
        """
        away = points - (tip + self.length * axis)
        distance2 = (away**2).sum(axis=1)
        if not len(points) or distance2.min() > self.contact**2:
            return np.zeros(len(points), dtype=bool)
        along = away @ axis
        under = distance2 - along**2 <= self.radius**2
        facing = normals @ axis < 0.0
        return np.asarray(under & facing & (np.abs(along) <= 0.5 * self.radius))
