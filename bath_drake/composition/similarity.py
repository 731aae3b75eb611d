"""Similarities of canonical space, which carry a field with its proof along."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray


@dataclass(frozen=True, eq=False)
class Similarity:
    """The map q -> pivot + shift + stretch (q - pivot), stretch as a complex number.

    It turns by the angle of ``stretch`` and scales by its length. gamma and every
    beta_i of a moved field are those of the field times constants, so that psi changes
    by a constant only: flow, critical points and proof move along.

    Attributes:
        pivot: Shape (2,), in N.
        stretch: Not zero.
        shift: Where the pivot goes, from itself, shape (2,).

    Raises:
        ValueError: A number is not finite, or the stretch is zero.
    """

    pivot: FloatArray
    stretch: complex
    shift: FloatArray

    def __post_init__(self) -> None:
        for name in ("pivot", "shift"):
            value = np.array(getattr(self, name), dtype=np.float64)
            if value.shape != (2,) or not np.isfinite(value).all():
                raise ValueError(f"{name} must be two finite numbers, got {value}")
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        stretch = complex(self.stretch)
        if not 0.0 < abs(stretch) < np.inf:
            raise ValueError(f"stretch must be finite and not zero, got {stretch}")
        object.__setattr__(self, "stretch", stretch)

    @property
    def scale(self) -> float:
        """By how much lengths grow."""
        return abs(self.stretch)

    @property
    def turn(self) -> float:
        """By how much directions turn, counter-clockwise, rad."""
        return float(np.angle(self.stretch))

    @property
    def is_identity(self) -> bool:
        """Whether nothing moves at all."""
        return self.stretch == 1.0 and not self.shift.any()

    def points(self, q: ArrayLike) -> FloatArray:
        """Moves points (..., 2)."""
        return self.pivot + self.shift + self.directions(np.asarray(q) - self.pivot)

    def back(self, q: ArrayLike) -> FloatArray:
        """Moves points (..., 2) back: the inverse of `points`."""
        away = np.asarray(q, dtype=np.float64) - self.pivot - self.shift
        return self.pivot + _times(1.0 / self.stretch, away)

    def directions(self, v: ArrayLike) -> FloatArray:
        """Turns and scales vectors (..., 2)."""
        return _times(self.stretch, np.asarray(v, dtype=np.float64))

    def field(self, field: NavigationField) -> NavigationField:
        """Moves a field whole: workspace, goal and obstacles.

        Raises:
            ValueError: The workspace is not a disc; a turned superellipse has no place
                in `Workspace`.
        """
        if self.is_identity:
            return field
        rim = field.workspace
        if rim.power != 2 or rim.semi_axes[0] != rim.semi_axes[1]:
            raise ValueError("only fields in a round workspace can be turned")
        theta = field.obstacles.theta.copy()
        theta[:, :2] = self.points(theta[:, :2])
        theta[:, 2:4] *= self.scale
        theta[:, 4] += self.turn
        return NavigationField(
            Workspace(self.points(rim.centre), self.scale * rim.semi_axes),
            self.points(field.goal),
            field.kappa,
            ObstacleSet(theta, field.obstacles.powers),
        )


def identity() -> Similarity:
    """The similarity that moves nothing."""
    return Similarity(np.zeros(2), 1.0, np.zeros(2))


def _times(factor: complex, v: FloatArray) -> FloatArray:
    a, b = factor.real, factor.imag
    x, y = v[..., 0], v[..., 1]
    return np.stack([a * x - b * y, b * x + a * y], axis=-1)
