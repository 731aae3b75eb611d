"""The field in plain numpy, whole arrays at a time, to compare compiled code with.

Written as one would without a compiler, from the same formulas (see
`bath_drake.field.navigation`); meant for points in free space, off the goal. The
roll-out takes the steps of the compiled one, all starts in lock-step.
"""

from typing import NamedTuple

import numpy as np

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import beta, grad_beta, hessian_beta
from bath_drake.notation import FloatArray


def psi(q: FloatArray, field: NavigationField) -> FloatArray:
    """The potential psi at points (..., 2), shape (...); inf outside free space."""
    rim = field.workspace.beta(q)
    betas = beta(q, field.obstacles)
    gamma = ((q - field.goal) ** 2).sum(axis=-1)
    free = (rim > 0.0) & (betas > 0.0).all(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        value = field.kappa * np.log(gamma) - np.log(rim)
        value -= (field.obstacles.powers * np.log(betas)).sum(axis=-1)
    return np.where(free, value, np.inf)


def flow_direction(q: FloatArray, field: NavigationField) -> FloatArray:
    """Unit vectors along -grad phi at points (..., 2); zero outside free space."""
    d = q - field.goal
    gamma = (d * d).sum(axis=-1, keepdims=True)
    workspace, p = field.workspace, field.workspace.power
    e = (q - workspace.centre) / workspace.semi_axes
    rim = 1.0 - (e**p).sum(axis=-1, keepdims=True)
    betas = beta(q, field.obstacles)
    push = -p * e ** (p - 1) / workspace.semi_axes / rim
    quotients = field.obstacles.powers / betas
    push = push + (quotients[..., None] * grad_beta(q, field.obstacles)).sum(axis=-2)
    v = gamma * push - 2.0 * field.kappa * d
    free = (rim[..., 0] > 0.0) & (betas > 0.0).all(axis=-1)
    length = np.linalg.norm(v, axis=-1)
    scale = np.divide(1.0, length, out=np.zeros_like(length), where=free & (length > 0))
    return np.asarray(v * scale[..., None])


class Derivatives(NamedTuple):
    """psi's derivatives at points (..., 2); not finite on boundaries and at the goal.

    Attributes:
        min_beta: The smallest beta_i, shape (...).
        gradient: Shape (..., 2).
        hessian: Shape (..., 2, 2).
        force: The sum of the lengths of the gradient's terms, shape (...): what its
            rounding errors are to be measured by.
        stiffness: The same for the Hessian.
    """

    min_beta: FloatArray
    gradient: FloatArray
    hessian: FloatArray
    force: FloatArray
    stiffness: FloatArray


def derivatives(q: FloatArray, field: NavigationField) -> Derivatives:
    """Gradient and Hessian of psi at points (..., 2)."""
    a, power = field.workspace.semi_axes, field.workspace.power
    e = (q - field.workspace.centre) / a
    rim = 1.0 - (e**power).sum(axis=-1, keepdims=True)
    bend = -power * (power - 1) * e ** (power - 2) / a**2
    # The rim first, then the obstacles, along an axis of their own.
    betas = np.concatenate([rim, beta(q, field.obstacles)], axis=-1)
    slopes = np.concatenate(
        [(-power * e ** (power - 1) / a)[..., None, :], grad_beta(q, field.obstacles)],
        axis=-2,
    )
    bends = np.empty((*betas.shape, 2, 2))
    bends[..., 0, :, :] = bend[..., None] * np.eye(2)
    bends[..., 1:, :, :] = hessian_beta(field.obstacles)
    p = q - field.goal
    gamma = (p * p).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        k = 2.0 * field.kappa / gamma
        w = np.concatenate([[1.0], field.obstacles.powers]) / betas
        gradient = k[..., None] * p - np.einsum("...j,...jx->...x", w, slopes)
        outer = np.einsum("...x,...y->...xy", p, p) * (2.0 / gamma)[..., None, None]
        hessian = k[..., None, None] * (np.eye(2) - outer)
        hessian += np.einsum("...j,...jx,...jy->...xy", w / betas, slopes, slopes)
        hessian -= np.einsum("...j,...jxy->...xy", w, bends)
        length = np.linalg.norm(slopes, axis=-1)
        weight = np.abs(w)
        force = k * np.sqrt(gamma) + (weight * length).sum(axis=-1)
        size = np.abs(bends).sum(axis=(-2, -1))
        stiffness = k + (weight * (length**2 / np.abs(betas) + size)).sum(axis=-1)
    return Derivatives(betas.min(axis=-1), gradient, hessian, force, stiffness)


def rollout_ends(
    starts: FloatArray,
    field: NavigationField,
    *,
    step: float,
    max_steps: int,
    goal_tolerance: float = 1e-3,
) -> FloatArray:
    """Where guarded midpoint roll-outs from free points (n, 2) end, shape (n, 2).

    Steps of arc length `step`, halved until psi falls; see `bath_drake.field.rollout`.
    """
    q = np.array(starts)
    value = psi(q, field)
    h = np.full(len(q), step)
    moving = np.isfinite(value)
    for _ in range(max_steps):
        distance = np.linalg.norm(q - field.goal, axis=-1)
        moving &= distance > goal_tolerance
        left = np.flatnonzero(moving)
        if left.size == 0:
            break
        h[left] = np.minimum(np.minimum(2.0 * h[left], step), distance[left])
        direction = flow_direction(q[left], field)
        while left.size:
            half = 0.5 * h[left, None]
            there = q[left] + h[left, None] * flow_direction(
                q[left] + half * direction, field
            )
            after = psi(there, field)
            falls = after < value[left]
            q[left[falls]] = there[falls]
            value[left[falls]] = after[falls]
            left, direction = left[~falls], direction[~falls]
            h[left] *= 0.5
            # Far below any step worth taking: a critical point holds it.
            stuck = h[left] < 1e-7 * step
            moving[left[stuck]] = False
            left, direction = left[~stuck], direction[~stuck]
    return q
