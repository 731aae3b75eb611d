"""A field as intervals: what the kernels of the proof work on."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from bath_drake.certificate.intervals import (
    above,
    add,
    below,
    divide,
    multiply,
    point,
    square,
    subtract,
    widen,
)
from bath_drake.field.navigation import NavigationField
from bath_drake.notation import FloatArray

# Libraries' sine and cosine err by less than a unit in the last place, which for values
# up to 1 is 2^-53; four times that.
_TRIGONOMETRIC_ERROR = 2.0 * 2.0**-52


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """By how much obstacles may differ from their rows.

    A certificate with it holds for every realisation: each centre coordinate within
    `centres` and each semi-axis within `semi_axes` of the row's, one by one.

    Attributes:
        centres: Half widths in N, shape (Q,), or one number for all; >= 0.
        semi_axes: Half widths in N, shape (Q,), or one number for all; >= 0.

    Raises:
        ValueError: A number is negative or not finite.
    """

    centres: ArrayLike = 0.0
    semi_axes: ArrayLike = 0.0

    def __post_init__(self) -> None:
        for name in ("centres", "semi_axes"):
            value = np.array(getattr(self, name), dtype=np.float64)
            if not (np.isfinite(value).all() and (value >= 0.0).all()):
                raise ValueError(f"{name} must be finite and >= 0, got {value}")
            value.setflags(write=False)
            object.__setattr__(self, name, value)


class World(NamedTuple):
    """A field's numbers; those of obstacles as intervals.

    Attributes:
        rim: The workspace: centre x, centre y, a, b, power; shape (5,), exact.
        goal: q_d, shape (2,), exact.
        kappa: Exact.
        obstacles: Rows of low and high ends of centre x, centre y, A, B, C with
            beta = A dx^2 + 2 B dx dy + C dy^2 - 1; shape (Q, 5, 2).
        exponents: w of the rim, 1, and of every obstacle; shape (Q + 1,), exact.
    """

    rim: FloatArray
    goal: FloatArray
    kappa: float
    obstacles: FloatArray
    exponents: FloatArray


def interval_world(field: NavigationField, uncertainty: Uncertainty | None) -> World:
    """Encloses a field.

    Raises:
        ValueError: The uncertainty does not fit the obstacles: another number of
            them, or a semi-axis that could be zero.
    """
    theta = field.obstacles.theta.copy()
    count = len(theta)
    slack = np.zeros((count, 2))
    if uncertainty is not None:
        for column, name in enumerate(("centres", "semi_axes")):
            given = np.asarray(getattr(uncertainty, name))
            if given.shape not in ((), (count,)):
                raise ValueError(
                    f"uncertainty of {name}: got shape {given.shape}, allowed: one "
                    f"number or ({count},)"
                )
            slack[:, column] = given
        if (theta[:, 2:4].min(axis=1, initial=np.inf) <= slack[:, 1]).any():
            raise ValueError(
                "uncertainty of semi_axes must be less than every semi-axis"
            )
    return World(
        field.workspace.as_array(),
        field.goal.copy(),
        field.kappa,
        _enclose(theta, slack),
        np.concatenate([[1.0], field.obstacles.powers]),
    )


@njit(cache=True)
def _enclose(theta: FloatArray, slack: FloatArray) -> FloatArray:
    rows = np.empty((theta.shape[0], 5, 2))
    for i in range(theta.shape[0]):
        angle = theta[i, 4]
        a = point(theta[i, 2])
        b = point(theta[i, 3])
        x = point(theta[i, 0])
        y = point(theta[i, 1])
        if slack[i, 0] > 0.0:
            x = widen(x, slack[i, 0])
            y = widen(y, slack[i, 0])
        c = widen(point(math.cos(angle)), _TRIGONOMETRIC_ERROR)
        s = widen(point(math.sin(angle)), _TRIGONOMETRIC_ERROR)
        if angle == 0.0:
            c = point(1.0)
            s = point(0.0)
        disc = a[0] == b[0]
        if slack[i, 1] > 0.0:
            disc = False  # the axes vary one by one
            a = widen(a, slack[i, 1])
            b = widen(b, slack[i, 1])
        p = divide(point(1.0), square(a))
        r = divide(point(1.0), square(b))
        xx, xy, yy = p, point(0.0), p
        if not disc:
            cc = square(c)
            ss = square(s)
            xx = add(multiply(cc, p), multiply(ss, r))
            xy = multiply(multiply(c, s), subtract(p, r))
            yy = add(multiply(ss, p), multiply(cc, r))
        row = (x, y, xx, xy, yy)
        for k in range(5):
            rows[i, k, 0], rows[i, k, 1] = row[k]
    return rows


@njit(cache=True)
def log_bounds(x: float) -> tuple[float, float]:
    """Bounds of ln x for x > 0; libraries err by a unit or two in the last place."""
    value = math.log(x)
    slack = 8.0 * 2.0**-52 * (abs(value) + 1.0)
    return below(value - slack), above(value + slack)
