"""Virtual obstacles and the workspace: the functions beta_i (paper, Sec. III-A).

An obstacle is an ellipse with an exponent, the workspace a superellipse. Both
are implicit functions, positive in free space and zero on their boundary.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.notation import BoolArray, FloatArray


def _read_only(values: ArrayLike) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class ObstacleSet:
    """Q ellipses in canonical space N.

    Attributes:
        theta: Rows (centre x, centre y, semi-axis a, semi-axis b, angle),
            shape (Q, 5); the angle is counter-clockwise, in radians.
        exponents: The power w_i of each beta_i in the product, shape (Q,);
            ones by default.

    Raises:
        ValueError: A shape is wrong, a number is not finite, or an axis or an
            exponent is not positive.
    """

    theta: FloatArray = field(default_factory=lambda: np.empty((0, 5)))
    exponents: FloatArray | None = None

    def __post_init__(self) -> None:
        theta = _read_only(self.theta)
        if theta.ndim != 2 or theta.shape[1] != 5:
            raise ValueError(f"theta must have shape (Q, 5), got {theta.shape}")
        given = self.exponents
        exponents = _read_only(np.ones(len(theta)) if given is None else given)
        if exponents.shape != (len(theta),):
            raise ValueError(
                f"exponents must have shape ({len(theta)},), got {exponents.shape}"
            )
        finite = np.isfinite(theta).all(axis=1) & np.isfinite(exponents)
        bad = np.logical_not(finite)
        if bad.any():
            raise ValueError(f"obstacle {int(np.argmax(bad))} has a non-finite number")
        bad = np.asarray((theta[:, 2:4] <= 0.0).any(axis=1))
        if bad.any():
            i = int(np.argmax(bad))
            axes = theta[i, 2:4].tolist()
            raise ValueError(f"obstacle {i}: semi-axes must be positive, got {axes}")
        bad = np.asarray(exponents <= 0.0)
        if bad.any():
            i = int(np.argmax(bad))
            raise ValueError(
                f"obstacle {i}: the exponent must be positive, got {exponents[i]}"
            )
        object.__setattr__(self, "theta", theta)
        object.__setattr__(self, "exponents", exponents)

    @property
    def powers(self) -> FloatArray:
        """The exponents, shape (Q,), for a type checker that asks."""
        assert self.exponents is not None  # set in __post_init__
        return self.exponents

    def __len__(self) -> int:
        return len(self.theta)

    def __add__(self, other: "ObstacleSet") -> "ObstacleSet":
        if len(other) == 0:
            return self
        return ObstacleSet(
            np.concatenate([self.theta, other.theta]),
            np.concatenate([self.powers, other.powers]),
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ObstacleSet):
            return NotImplemented
        if self is other:
            return True
        return np.array_equal(self.theta, other.theta) and np.array_equal(
            self.powers, other.powers
        )

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.theta.tobytes(), self.powers.tobytes()))

    def boundary(self, count: int = 64) -> FloatArray:
        """Points on every ellipse, shape (Q, count, 2), counter-clockwise."""
        t = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
        c = np.cos(self.theta[:, 4:])
        s = np.sin(self.theta[:, 4:])
        u = self.theta[:, 2:3] * np.cos(t)
        v = self.theta[:, 3:4] * np.sin(t)
        points = np.stack([c * u - s * v, s * u + c * v], axis=-1)
        return np.asarray(self.theta[:, None, :2] + points)


@dataclass(frozen=True, eq=False)
class Workspace:
    """The superellipse |dx/a|^p + |dy/b|^p <= 1 that holds the motion.

    Attributes:
        centre: Shape (2,), in N.
        semi_axes: a and b, shape (2,), positive.
        power: p, even and at least 2, so that beta_0 is smooth.

    Raises:
        ValueError: A value is not of that kind.
    """

    centre: FloatArray
    semi_axes: FloatArray
    power: int = 2

    def __post_init__(self) -> None:
        for name in ("centre", "semi_axes"):
            value = _read_only(getattr(self, name))
            if value.shape != (2,) or not np.isfinite(value).all():
                raise ValueError(f"{name} must be two finite numbers, got {value}")
            object.__setattr__(self, name, value)
        if not (self.semi_axes > 0.0).all():
            raise ValueError(f"semi_axes must be positive, got {self.semi_axes}")
        if self.power != int(self.power) or self.power < 2 or self.power % 2:
            raise ValueError(f"power must be even and >= 2, got {self.power}")
        object.__setattr__(self, "power", int(self.power))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Workspace):
            return NotImplemented
        if self is other:
            return True
        return bool(np.array_equal(self.as_array(), other.as_array()))

    def __hash__(self) -> int:
        return hash(self.as_array().tobytes())

    def as_array(self) -> FloatArray:
        """(centre x, centre y, a, b, power), the kernels' form."""
        return np.array([*self.centre, *self.semi_axes, self.power], dtype=np.float64)

    def beta(self, q: FloatArray) -> FloatArray:
        """beta_0 at points (..., 2): 1 at the centre, 0 on the rim."""
        d = np.abs((np.asarray(q, dtype=np.float64) - self.centre) / self.semi_axes)
        return np.asarray(1.0 - (d**self.power).sum(axis=-1))


def _own_axes(
    q: FloatArray, obstacles: ObstacleSet
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Points as (u, v) in every ellipse's own axes, and the cosines and sines."""
    d = np.asarray(q, dtype=np.float64)[..., None, :] - obstacles.theta[:, :2]
    c = np.cos(obstacles.theta[:, 4])
    s = np.sin(obstacles.theta[:, 4])
    return c * d[..., 0] + s * d[..., 1], c * d[..., 1] - s * d[..., 0], c, s


def beta(q: FloatArray, obstacles: ObstacleSet) -> FloatArray:
    """beta_i = (u/a)^2 + (v/b)^2 - 1 at points (..., 2), shape (..., Q)."""
    u, v, _, _ = _own_axes(q, obstacles)
    a, b = obstacles.theta[:, 2], obstacles.theta[:, 3]
    return np.asarray((u / a) ** 2 + (v / b) ** 2 - 1.0)


def grad_beta(q: FloatArray, obstacles: ObstacleSet) -> FloatArray:
    """Gradients of beta_i at points (..., 2), shape (..., Q, 2)."""
    u, v, c, s = _own_axes(q, obstacles)
    gu = 2.0 * u / obstacles.theta[:, 2] ** 2
    gv = 2.0 * v / obstacles.theta[:, 3] ** 2
    return np.stack([c * gu - s * gv, s * gu + c * gv], axis=-1)


def hessian_beta(obstacles: ObstacleSet) -> FloatArray:
    """Hessians of beta_i, the same at every point, shape (Q, 2, 2)."""
    c, s = np.cos(obstacles.theta[:, 4]), np.sin(obstacles.theta[:, 4])
    p, r = 2.0 / obstacles.theta[:, 2] ** 2, 2.0 / obstacles.theta[:, 3] ** 2
    xy = c * s * (p - r)
    flat = np.stack([c * c * p + s * s * r, xy, xy, s * s * p + c * c * r], axis=-1)
    return flat.reshape(-1, 2, 2)


def support(obstacles: ObstacleSet, directions: FloatArray) -> FloatArray:
    """How far each ellipse reaches along unit vectors (n, 2), shape (n, Q)."""
    c, s = np.cos(obstacles.theta[:, 4]), np.sin(obstacles.theta[:, 4])
    x, y = directions[:, :1], directions[:, 1:]
    along_a = obstacles.theta[:, 2] * (c * x + s * y)
    along_b = obstacles.theta[:, 3] * (c * y - s * x)
    return np.asarray(np.hypot(along_a, along_b))


def pair_gaps(obstacles: ObstacleSet, count: int = 720) -> FloatArray:
    """Widths of the widest straight slit between each two ellipses, shape (Q, Q).

    The separating-axis distance over ``count`` directions: for disjoint ellipses
    their distance (from below, to a relative 1e-5 at 720), negative when they
    overlap; infinite on the diagonal.
    """
    t = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    n = np.stack([np.cos(t), np.sin(t)], axis=-1)
    reach = support(obstacles, n)
    along = n @ obstacles.theta[:, :2].T
    # Slit from i's far side to j's near side; symmetric, so both orders count.
    slit = (along - reach)[:, None, :] - (along + reach)[:, :, None]
    gaps = np.asarray(slit.max(axis=0))
    np.fill_diagonal(gaps, np.inf)
    return np.asarray(np.maximum(gaps, gaps.T))


def curvature_margin(obstacles: ObstacleSet, goal: FloatArray) -> FloatArray:
    """How round each ellipse looks from the goal, shape (Q,); <= 0 traps.

    For large kappa an obstacle adds a spurious minimum behind it unless, at each
    boundary point where the outward normal points straight away from the goal,
    curvature times distance to the goal exceeds one: that is, unless the distance
    along the boundary has a second minimum there, which it has just when the goal
    lies within the ellipse's evolute

        (a |u|)^(2/3) + (b |v|)^(2/3) = |a^2 - b^2|^(2/3).

    Returned is the quotient of both sides less one (infinite for a circle).
    """
    u, v, _, _ = _own_axes(goal, obstacles)
    a, b = obstacles.theta[:, 2], obstacles.theta[:, 3]
    reach = np.cbrt(a * np.abs(u)) ** 2 + np.cbrt(b * np.abs(v)) ** 2
    evolute = np.cbrt(np.abs(a * a - b * b)) ** 2
    with np.errstate(divide="ignore"):
        return np.asarray(
            np.where(evolute > 0.0, reach / np.maximum(evolute, 1e-300) - 1.0, np.inf)
        )


def suits_large_kappa(obstacles: ObstacleSet, goal: FloatArray) -> BoolArray:
    """Whether each ellipse, alone, leaves no spurious minimum as kappa grows: (Q,)."""
    return np.asarray(curvature_margin(obstacles, goal) > 0.0)
