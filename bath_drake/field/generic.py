"""The navigation function for any scalar: float, AutoDiffXd, Expression.

The compiled kernels know floats only. Here the same field is written with
``+ - * / **`` and numpy's ``log exp sqrt cos sin``, which numpy hands on to a scalar's
own methods; nothing here knows Drake. One point at a time: batches of floats are
what `bath_drake.field.navigation` is for.

As they stand, the functions agree with that module, outside free space too. They
differ in one thing, so that no derivative becomes infinite: gamma is floored at
1e-300 under a logarithm, hence psi and ln phi are large and negative at the goal
instead of -inf.

With ``plain=True`` they compare nothing, for scalars whose comparisons are not true
or false: a symbolic Expression becomes the formula of the paper, differentiable any
number of times. It holds in free space only, and its gamma^kappa in Eq. 1 overflows
from kappa ln(gamma) = 709 on (kappa near 200 in a field 6 across).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bath_drake.field.navigation import NavigationField
from bath_drake.field.parameters import pack_field, split_parameters

# A float, an AutoDiffXd or an Expression: nothing they share has a type.
Scalar = Any
# beta_i, its derivatives along x and y, and w_i.
_Boundary = tuple[Scalar, Scalar, Scalar, Scalar]
_TINY = 1e-300
# Far outside, squares overflow; what is given there does not depend on them.
_quiet = np.errstate(over="ignore", invalid="ignore")


@dataclass(frozen=True, eq=False)
class GenericField:
    """A `NavigationField` whose numbers are scalars of any one kind.

    Attributes:
        centre: Of the workspace, two scalars.
        semi_axes: Of the workspace, two scalars.
        power: Of the workspace, an even whole number.
        goal: q_d, two scalars.
        kappa: The exponent of Eq. 1.
        rows: (centre x, centre y, a, b, angle, exponent) of each obstacle.
    """

    centre: Sequence[Scalar]
    semi_axes: Sequence[Scalar]
    power: int
    goal: Sequence[Scalar]
    kappa: Scalar
    rows: Sequence[Sequence[Scalar]]

    @classmethod
    def of(cls, field: NavigationField) -> "GenericField":
        """The same field, in floats."""
        return cls.from_vector(pack_field(field, len(field.obstacles)))

    @classmethod
    def from_vector(
        cls, vector: Any, value: Callable[[Scalar], float] = float
    ) -> "GenericField":
        """Reads what `bath_drake.field.parameters.pack_field` wrote.

        Args:
            vector: Scalars, shape (9 + 6 n,).
            value: Gives a scalar as a float; asked for the two whole numbers, the
                workspace's power and the number of obstacles.

        Raises:
            ValueError: The length, the power or the number cannot be.
        """
        head, rows, power = split_parameters(vector, value)
        return cls(
            centre=head[0:2],
            semi_axes=head[2:4],
            power=power,
            goal=head[5:7],
            kappa=head[7],
            rows=rows,
        )


def _boundaries(q: Sequence[Scalar], field: GenericField) -> list[_Boundary]:
    """The workspace's, then the obstacles'."""
    u, v = ((q[k] - field.centre[k]) / field.semi_axes[k] for k in (0, 1))
    p = field.power
    found = [
        (
            1.0 - u**p - v**p,
            -p * u ** (p - 1) / field.semi_axes[0],
            -p * v ** (p - 1) / field.semi_axes[1],
            1.0,
        )
    ]
    for x, y, a, b, angle, exponent in field.rows:
        c, s = np.cos(angle), np.sin(angle)
        dx, dy = q[0] - x, q[1] - y
        u, v = (c * dx + s * dy) / a, (c * dy - s * dx) / b
        value = u * u + v * v - 1.0
        slope_x = 2.0 * (c * u / a - s * v / b)
        slope_y = 2.0 * (s * u / a + c * v / b)
        found.append((value, slope_x, slope_y, exponent))
    return found


def _offset(q: Sequence[Scalar], field: GenericField) -> tuple[Scalar, Scalar, Scalar]:
    """The vector q - q_d and gamma."""
    dx, dy = q[0] - field.goal[0], q[1] - field.goal[1]
    return dx, dy, dx * dx + dy * dy


def constant(value: float, q: Sequence[Scalar], field: GenericField) -> Scalar:
    """A number as a scalar of the kind at hand.

    A plain float would do by its value, but an AutoDiffXd made of it has no
    derivatives instead of zeros, and compiled code that takes their number for
    granted crashes (DirectCollocation does).
    """
    numbers = [*q, *field.centre, *field.semi_axes, *field.goal, field.kappa]
    for row in field.rows:
        numbers.extend(row)
    return value + sum(0.0 * number for number in numbers)


@_quiet
def betas(q: Sequence[Scalar], field: GenericField) -> list[Scalar]:
    """beta_0 of the workspace, then beta_i of every obstacle; free space: all > 0."""
    return [b for b, _, _, _ in _boundaries(q, field)]


def _ln_beta(boundaries: Sequence[_Boundary]) -> Scalar:
    return sum(w * np.log(b) for b, _, _, w in boundaries)


def _is_free(boundaries: Sequence[_Boundary]) -> bool:
    return all(b > 0.0 for b, _, _, _ in boundaries)


@_quiet
def psi(q: Sequence[Scalar], field: GenericField, *, plain: bool = False) -> Scalar:
    """The potential kappa ln gamma - sum_i w_i ln beta_i; +inf off free space."""
    boundaries = _boundaries(q, field)
    _, _, gamma = _offset(q, field)
    if not plain:
        if not _is_free(boundaries):
            return constant(np.inf, q, field)
        gamma = gamma + _TINY
    return field.kappa * np.log(gamma) - _ln_beta(boundaries)


@_quiet
def ln_phi(q: Sequence[Scalar], field: GenericField, *, plain: bool = False) -> Scalar:
    """The logarithm -softplus(-psi) / kappa of phi; 0 off free space."""
    if plain:
        return np.log(phi(q, field, plain=True))
    boundaries = _boundaries(q, field)
    if not _is_free(boundaries):
        return constant(0.0, q, field)
    _, _, gamma = _offset(q, field)
    level = field.kappa * np.log(gamma + _TINY) - _ln_beta(boundaries)
    if level < 0.0:
        return (level - np.log(1.0 + np.exp(level))) / field.kappa
    return -np.log(1.0 + np.exp(-level)) / field.kappa


@_quiet
def phi(q: Sequence[Scalar], field: GenericField, *, plain: bool = False) -> Scalar:
    """The navigation function (Eq. 1), in [0, 1]; 1 off free space.

    With e = gamma^kappa / beta it is gamma (beta (1 + e))^(-1/kappa) where e < 1, so
    it is regular at the goal, and (1 + 1/e)^(-1/kappa) elsewhere, so that far away,
    where phi is 1 to rounding, its gradient keeps its digits.
    """
    boundaries = _boundaries(q, field)
    _, _, gamma = _offset(q, field)
    if plain:
        beta = 1.0
        for b, _, _, w in boundaries:
            beta = beta * b**w
        return gamma / (gamma**field.kappa + beta) ** (1.0 / field.kappa)
    if not _is_free(boundaries):
        return constant(1.0, q, field)
    ln_beta = _ln_beta(boundaries)
    level = field.kappa * np.log(gamma + _TINY) - ln_beta
    if level < 0.0:
        fall = ln_beta + np.log(1.0 + np.exp(level))
        return gamma * np.exp(-fall / field.kappa)
    return np.exp(-np.log(1.0 + np.exp(-level)) / field.kappa)


def _flow(
    boundaries: Sequence[_Boundary],
    q: Sequence[Scalar],
    field: GenericField,
) -> tuple[Scalar, Scalar]:
    # After each step: product = prod beta_j and (sx, sy) = sum_j w_j grad(beta_j)
    # prod_{i != j} beta_i over the boundaries so far.
    product, sx, sy = 1.0, 0.0, 0.0
    for b, bx, by, w in boundaries:
        sx = sx * b + w * bx * product
        sy = sy * b + w * by * product
        product = product * b
    dx, dy, gamma = _offset(q, field)
    pull = 2.0 * field.kappa * product
    return gamma * sx - pull * dx, gamma * sy - pull * dy


@_quiet
def flow(q: Sequence[Scalar], field: GenericField) -> tuple[Scalar, Scalar]:
    """A polynomial vector field along -grad phi: no root, quotient or case.

    It is -gamma (prod_i beta_i) grad psi, in free space a positive multiple of
    -grad phi: the same integral curves and, the goal included, the same zeros.
    Nothing is promised outside free space.
    """
    return _flow(_boundaries(q, field), q, field)


@_quiet
def flow_direction(
    q: Sequence[Scalar], field: GenericField, *, plain: bool = False
) -> tuple[Scalar, Scalar]:
    """The unit vector along -grad phi (Eq. 2); the inward normal on a boundary.

    Zero at the goal, at critical points and outside free space; with ``plain`` it
    is undefined at the first two.
    """
    boundaries = _boundaries(q, field)
    x, y = _flow(boundaries, q, field)
    square = x * x + y * y
    if not plain:
        if not all(b >= 0.0 for b, _, _, _ in boundaries) or not square > 0.0:
            zero = constant(0.0, q, field)
            return zero, zero
    length = np.sqrt(square)
    return x / length, y / length
