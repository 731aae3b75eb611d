"""The navigation function and its flow, in logarithms (paper, Eq. 1 and 2).

With gamma = |q - q_d|^2 and beta = prod_i beta_i^w_i (i = 0 the workspace),

    phi = gamma / (gamma^kappa + beta)^(1/kappa).

Its integral curves are those of psi = kappa ln gamma - sum_i w_i ln beta_i, and
ln phi = -ln(1 + exp(-psi)) / kappa, so no power is ever taken.

Everything is defined and finite for every finite q (ln phi is -inf at the goal):

* on a boundary phi = 1 and the flow is the boundary's inward normal; where several
  boundaries cross, the sum of their gradients, scaled to one;
* outside free space (some beta_i < 0) phi = 1, and its derivatives and the flow are
  zero;
* at the goal phi = 0, gradient and flow are zero, and the Hessian of phi is
  2 beta(q_d)^(-1/kappa) I;
* the derivatives of psi are zero wherever psi is not finite.

Coordinates beyond 1e70 count as 1e70, semi-axes below 1e-35 as 1e-35.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.field import _kernels
from bath_drake.field._boundaries import FAR, compiled, quadratic_forms
from bath_drake.field._boundaries import min_beta as _least_beta
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray

# Worlds of a field and further obstacles that it remembers.
_KEPT = 8


@dataclass(frozen=True, eq=False)
class NavigationField:
    """Everything that fixes phi.

    Attributes:
        workspace: The outer boundary.
        goal: q_d, shape (2,), in N. It may lie anywhere; whether the field is
            a navigation function is for `certificate.certify.certify` to say.
        kappa: The exponent of Eq. 1, positive.
        obstacles: The inner boundaries.

    Raises:
        ValueError: The goal is not two finite numbers or kappa not positive.
    """

    workspace: Workspace
    goal: FloatArray
    kappa: float
    obstacles: ObstacleSet

    def __post_init__(self) -> None:
        goal = np.array(self.goal, dtype=np.float64)
        if goal.shape != (2,) or not np.isfinite(goal).all():
            raise ValueError(f"goal must be two finite numbers, got {self.goal}")
        goal.setflags(write=False)
        object.__setattr__(self, "goal", goal)
        kappa = float(self.kappa)
        if not (0.0 < kappa < np.inf):
            raise ValueError(f"kappa must be positive and finite, got {self.kappa}")
        object.__setattr__(self, "kappa", kappa)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, NavigationField):
            return NotImplemented
        if self is other:
            return True
        return (
            self.workspace == other.workspace
            and np.array_equal(self.goal, other.goal)
            and self.kappa == other.kappa
            and self.obstacles == other.obstacles
        )

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        parts = (self.workspace, self.goal.tobytes(), self.kappa, self.obstacles)
        return hash(parts)

    def with_obstacles(self, extra: ObstacleSet) -> "NavigationField":
        """The same field with further obstacles: another world, to be checked anew."""
        if len(extra) == 0:
            return self
        # Asked for hundreds of times a second of one world: one answer, with its forms.
        if extra not in self._joined:
            if len(self._joined) >= _KEPT:
                self._joined.clear()
            together = replace(self, obstacles=self.obstacles + extra)
            self._joined[extra] = together
        return self._joined[extra]

    def with_goal(self, goal: FloatArray) -> "NavigationField":
        """The same field with another goal: another world, to be checked anew."""
        return replace(self, goal=goal)

    @cached_property
    def _joined(self) -> dict[ObstacleSet, "NavigationField"]:
        return {}

    @cached_property
    def kernel_arguments(
        self,
    ) -> tuple[FloatArray, float, float, float, FloatArray]:
        """(workspace, goal x, goal y, kappa, forms) as `_kernels` takes them."""
        theta, exponents = self.obstacles.theta, self.obstacles.powers
        # numba compiles anew for read-only arrays: hand out plain copies.
        forms = quadratic_forms(theta.copy(), exponents.copy())
        gx, gy = (min(max(g, -FAR), FAR) for g in self.goal.tolist())
        return self.workspace.as_array(), gx, gy, self.kappa, forms


def _points(q: ArrayLike) -> tuple[FloatArray, tuple[int, ...]]:
    q = np.asarray(q, dtype=np.float64)
    if q.ndim == 0 or q.shape[-1] != 2:
        raise ValueError(f"points must have shape (..., 2), got {q.shape}")
    return np.array(q.reshape(-1, 2), order="C"), q.shape[:-1]


_Kernel = Callable[..., FloatArray]


@compiled
def _min_beta(q, workspace, gx, gy, kappa, forms):  # type: ignore[no-untyped-def]
    out = np.empty(q.shape[0])
    for i in range(q.shape[0]):
        out[i] = _least_beta(q[i, 0], q[i, 1], workspace, forms)
    return out


@compiled
def _psi(q, workspace, gx, gy, kappa, forms):  # type: ignore[no-untyped-def]
    out = np.empty(q.shape[0])
    for i in range(q.shape[0]):
        out[i] = _kernels.psi(q[i, 0], q[i, 1], workspace, gx, gy, kappa, forms)
    return out


@compiled
def _ln_phi(q, workspace, gx, gy, kappa, forms):  # type: ignore[no-untyped-def]
    out = np.empty(q.shape[0])
    for i in range(q.shape[0]):
        out[i] = _kernels.ln_phi(q[i, 0], q[i, 1], workspace, gx, gy, kappa, forms)
    return out


@compiled
def _grad_phi(q, workspace, gx, gy, kappa, forms):  # type: ignore[no-untyped-def]
    out = np.empty((q.shape[0], 2))
    for i in range(q.shape[0]):
        x, y = q[i]
        row = _kernels.grad_phi(x, y, workspace, gx, gy, kappa, forms)
        for k in range(2):
            out[i, k] = row[k]
    return out


@compiled
def _hessian_phi(q, workspace, gx, gy, kappa, forms):  # type: ignore[no-untyped-def]
    out = np.empty((q.shape[0], 3))
    for i in range(q.shape[0]):
        x, y = q[i]
        row = _kernels.hessian_phi(x, y, workspace, gx, gy, kappa, forms)
        for k in range(3):
            out[i, k] = row[k]
    return out


@compiled
def _derivatives(q, workspace, gx, gy, kappa, forms):  # type: ignore[no-untyped-def]
    out = np.zeros((q.shape[0], 5))
    for i in range(q.shape[0]):
        x, y = q[i]
        if _least_beta(x, y, workspace, forms) > 0.0 and not (x == gx and y == gy):
            row = _kernels.grad_hessian_psi(x, y, workspace, gx, gy, kappa, forms)
            for k in range(5):
                out[i, k] = row[k]
    return out


def _over(kernel: _Kernel, q: ArrayLike, field: NavigationField) -> FloatArray:
    points, shape = _points(q)
    out = kernel(points, *field.kernel_arguments)
    return out.reshape(shape + out.shape[1:])


def min_beta(q: ArrayLike, field: NavigationField) -> FloatArray:
    """The smallest of all beta_i at points (..., 2), shape (...).

    The workspace's beta_0 counts. Positive in free space, zero on a boundary.
    """
    return _over(_min_beta, q, field)


def psi(q: ArrayLike, field: NavigationField) -> FloatArray:
    """The potential kappa ln gamma - sum_i w_i ln beta_i at (..., 2), shape (...).

    It is -inf at the goal, and inf on a boundary and outside free space.
    """
    return _over(_psi, q, field)


def ln_phi(q: ArrayLike, field: NavigationField) -> FloatArray:
    """The logarithm of phi at points (..., 2), shape (...); -inf at the goal."""
    return _over(_ln_phi, q, field)


def phi(q: ArrayLike, field: NavigationField) -> FloatArray:
    """The navigation function (Eq. 1) at points (..., 2), shape (...), in [0, 1]."""
    return np.asarray(np.exp(ln_phi(q, field)))


def grad_phi(q: ArrayLike, field: NavigationField) -> FloatArray:
    """Gradient of phi at points (..., 2), shape (..., 2).

    Exact on boundaries too; an exponent below one makes it infinite there, and at the
    goal's side of a boundary it grows like gamma^-kappa: it is cut off at exp(690).
    """
    return _over(_grad_phi, q, field)


def hessian_phi(q: ArrayLike, field: NavigationField) -> FloatArray:
    """Hessian of phi at points (..., 2), shape (..., 2, 2).

    On a boundary it is the limit from within free space (infinite for exponents
    below two other than one), cut off at exp(690).
    """
    return _over(_hessian_phi, q, field)[..., [[0, 1], [1, 2]]]


def flow_direction(q: ArrayLike, field: NavigationField) -> FloatArray:
    """Unit vector along -grad phi (Eq. 2) at points (..., 2), shape (..., 2).

    Zero at the goal, at critical points and outside free space.
    """
    return _over(_kernels.flows, q, field)


def grad_psi(q: ArrayLike, field: NavigationField) -> FloatArray:
    """Gradient of psi at points (..., 2), shape (..., 2).

    Zero at the goal, on boundaries and outside free space, where psi is not finite.
    """
    return _over(_derivatives, q, field)[..., :2]


def hessian_psi(q: ArrayLike, field: NavigationField) -> FloatArray:
    """Hessian of psi at points (..., 2), shape (..., 2, 2); zero where `grad_psi` says.

    Its part 2 kappa / gamma is cut off at 1e300.
    """
    return _over(_derivatives, q, field)[..., [[2, 3], [3, 4]]]
